#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string_view>

namespace lode::app {

/// An advisory file lock (flock). The destructor releases it; after the end of the process it lasts until
/// children that inherited the descriptor end. Move only.
class FileLock {
 public:
  enum class Kind : uint8_t { kShared, kExclusive };

  FileLock() = default;  ///< locks nothing
  ~FileLock();
  FileLock(FileLock&& other) noexcept;
  FileLock& operator=(FileLock&& other) noexcept;

  /// Tries to lock a file without waiting.
  /// @param make  creates the file if it is missing.
  /// @return nothing with errno 0 if another process holds the lock or the file was replaced meanwhile;
  /// nothing with another errno if the file cannot be opened or locked.
  static std::optional<FileLock> tryTake(const std::filesystem::path& path, Kind kind, bool make);

  int descriptor() const noexcept { return file_; }

 private:
  int file_ = -1;
};

/// Returns the folder of the user's caches: in XDG_CACHE_HOME, ~/.cache, or the folder of temporary files.
std::filesystem::path cacheFolder();

/// Lock file in the folder of a source. The program that builds holds it.
constexpr std::string_view kStoreBuildLock = "lock";
/// Record of the build beside a store. Its modification time is the store's last use.
constexpr std::string_view kBuildRecord = "built.json";

/// Returns the limit for all cached stores together: a tenth of their disk, at least 20 GB, at most half of
/// the disk.
uint64_t storeCacheBytes(uint64_t disk_bytes) noexcept;
/// The same for the disk of the folder `stores`, which has a subfolder per source.
uint64_t storeCacheBytes(const std::filesystem::path& stores);

/// Marks a store as used now, and locks it against removal. Call it while holding the lock of the source.
FileLock useStore(const std::filesystem::path& store);

/// Removes the least recently used stores until all take at most max_bytes. Keeps stores that are in use or
/// being built.
void trimStores(const std::filesystem::path& stores, uint64_t max_bytes);

}  // namespace lode::app
