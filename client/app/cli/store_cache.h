#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string_view>

#include "common/io/own_folder.h"

namespace lode::app {

/// An advisory file lock (flock). The lock lasts until this object is destroyed and every child process that
/// inherited the descriptor has ended. Move only.
class FileLock {
 public:
  enum class Kind : uint8_t { kShared, kExclusive };

  FileLock() = default;  ///< holds no lock
  ~FileLock();
  FileLock(FileLock&& other) noexcept;
  FileLock& operator=(FileLock&& other) noexcept;

  /// Tries to lock a file without waiting.
  /// @param make  true to create the file if it is missing.
  /// @return the lock, or nothing on failure. On failure, errno is 0 if another process holds the lock or has
  /// just replaced the file, and not 0 if the file cannot be opened or locked.
  static std::optional<FileLock> tryTake(const std::filesystem::path& path, Kind kind, bool make);

  int descriptor() const noexcept { return file_; }

 private:
  int file_ = -1;
};

/// Returns the program's cache folder, which lies in $XDG_CACHE_HOME, else in ~/.cache, else in the folder
/// for temporary files.
std::filesystem::path cacheFolder();

/// Returns the folder for stores in cacheFolder(). It has one subfolder per source.
std::filesystem::path storesFolder();

constexpr FolderUse kCacheFolderUse{"the cache", "set XDG_CACHE_HOME to a folder that can be written"};

/// Returns cacheFolder(). @throws Error kIo if the folder exists but belongs to another user, is a link, or
/// is writable by other users.
std::filesystem::path ownCacheFolder();

/// Name of the lock file in the cache folder of a source, the PLY file that stores are built from. A program
/// locks this file while it builds a store of the source.
constexpr std::string_view kStoreBuildLock = "lock";
/// Name of the file beside a store that records the build. The file's modification time is the time of the
/// store's last use.
constexpr std::string_view kBuildRecord = "built.json";

/// Returns the limit for all cached stores together: a tenth of the disk, but at least 20 GB, and never more
/// than half of the disk.
uint64_t storeCacheBytes(uint64_t disk_bytes) noexcept;
/// Returns the limit for the disk that contains the folder `stores`, which has one subfolder per source.
uint64_t storeCacheBytes(const std::filesystem::path& stores);

/// Records that a store is used now, and locks the store against removal. The caller must hold the source's
/// build lock during the call.
FileLock useStore(const std::filesystem::path& store);

/// Removes all stores of the least recently used sources until the remaining stores take at most max_bytes.
/// Keeps a source if one of its stores is in use or being built.
void trimStores(const std::filesystem::path& stores, uint64_t max_bytes);

}  // namespace lode::app
