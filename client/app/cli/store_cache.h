#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string_view>

#include "common/io/own_folder.h"

namespace lode::app {

/// An advisory file lock (flock). The destructor releases the lock. If the process ends first, the lock lasts
/// until all children that inherited the descriptor have ended. Move only.
class FileLock {
 public:
  enum class Kind : uint8_t { kShared, kExclusive };

  FileLock() = default;  ///< creates an object without a lock
  ~FileLock();
  FileLock(FileLock&& other) noexcept;
  FileLock& operator=(FileLock&& other) noexcept;

  /// Tries to lock a file without waiting.
  /// @param make  true creates the file if it is missing.
  /// @return the lock, or nothing. errno is then 0 if another process has the lock or the file was replaced
  /// meanwhile; errno is another value if the file cannot be opened or locked.
  static std::optional<FileLock> tryTake(const std::filesystem::path& path, Kind kind, bool make);

  int descriptor() const noexcept { return file_; }

 private:
  int file_ = -1;
};

/// Returns the program's folder for caches. The folder is in XDG_CACHE_HOME, else in ~/.cache, else in the
/// folder for temporary files.
std::filesystem::path cacheFolder();

constexpr FolderUse kCacheFolderUse{"the cache", "set XDG_CACHE_HOME to a folder that can be written"};

/// Returns cacheFolder(). @throws Error kIo if the folder exists but belongs to another user, is a link, or
/// others can write to it.
std::filesystem::path ownCacheFolder();

/// Name of the lock file in the folder of a source. The program that builds the source's store locks this
/// file.
constexpr std::string_view kStoreBuildLock = "lock";
/// Name of the file beside a store that records the build. The file's modification time is the time of the
/// store's last use.
constexpr std::string_view kBuildRecord = "built.json";

/// Returns the limit for all cached stores together: a tenth of the disk, but at least 20 GB, and never more
/// than half of the disk.
uint64_t storeCacheBytes(uint64_t disk_bytes) noexcept;
/// Returns the limit for the disk that contains the folder `stores`. The folder has a subfolder per source.
uint64_t storeCacheBytes(const std::filesystem::path& stores);

/// Marks a store as used now and locks it against removal. The caller must have the lock of the source during
/// the call.
FileLock useStore(const std::filesystem::path& store);

/// Removes the least recently used stores until the other stores take at most max_bytes. Keeps stores that
/// are in use or being built.
void trimStores(const std::filesystem::path& stores, uint64_t max_bytes);

}  // namespace lode::app
