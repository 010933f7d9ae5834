#include "client/app/cli/store_cache.h"

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/io/own_folder.h"

namespace lode::app {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kLeastBytes = 20'000'000'000;
constexpr uint64_t kShareOfDisk = 10;

/// The cache folder of a source file. It contains the stores of all versions of the source, and files that
/// killed builds left behind.
struct BuiltSource {
  fs::path folder;
  uint64_t bytes = 0;
  fs::file_time_type used = fs::file_time_type::min();
  std::vector<fs::path> stores;
};

BuiltSource lookAt(const fs::path& folder) {
  BuiltSource source;
  source.folder = folder;
  std::error_code failed;
  for (fs::recursive_directory_iterator entry(folder, failed), end; !failed && entry != end;
       entry.increment(failed)) {
    std::error_code gone;  // another program may remove the entry meanwhile
    if (!entry->is_regular_file(gone)) continue;
    const uint64_t bytes = entry->file_size(gone);
    const fs::file_time_type used = entry->last_write_time(gone);
    if (gone) continue;
    source.bytes += bytes;
    source.used = std::max(source.used, used);
    if (entry->path().extension() == ".lode") source.stores.push_back(entry->path());
  }
  return source;
}

/// Removes all stores of a source. @return false, with nothing removed, if a store is in use or being built.
bool remove(const BuiltSource& source) {
  const auto build_lock =
      FileLock::tryTake(source.folder / kStoreBuildLock, FileLock::Kind::kExclusive, true);
  if (!build_lock) return false;
  std::vector<FileLock> nobody_uses;
  for (const fs::path& store : source.stores) {
    auto lock = FileLock::tryTake(store, FileLock::Kind::kExclusive, false);
    if (!lock) return false;
    nobody_uses.push_back(std::move(*lock));
  }
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(source.folder, ignored))
    if (entry.path().filename() != kStoreBuildLock) fs::remove_all(entry.path(), ignored);
  // Remove the lock file after the stores: a program that waits for the lock then starts with a new folder.
  fs::remove(source.folder / kStoreBuildLock, ignored);
  fs::remove(source.folder, ignored);
  return true;
}

}  // namespace

FileLock::~FileLock() {
  if (file_ >= 0) close(file_);
}

FileLock::FileLock(FileLock&& other) noexcept : file_(std::exchange(other.file_, -1)) {}

FileLock& FileLock::operator=(FileLock&& other) noexcept {
  std::swap(file_, other.file_);
  return *this;
}

std::optional<FileLock> FileLock::tryTake(const std::filesystem::path& path, Kind kind, bool make) {
  FileLock lock;
  lock.file_ = make ? open(path.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0600)
                    : open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC);
  if (lock.file_ < 0) return std::nullopt;
  struct stat taken {};
  struct stat named {};
  const int operation = (kind == Kind::kShared ? LOCK_SH : LOCK_EX) | LOCK_NB;
  const bool is_locked = flock(lock.file_, operation) == 0;
  if (is_locked || errno == EWOULDBLOCK || errno == EINTR) errno = 0;
  const int why = errno;
  if (is_locked && fstat(lock.file_, &taken) == 0 && stat(path.c_str(), &named) == 0 &&
      taken.st_ino == named.st_ino)
    return lock;
  errno = why;
  return std::nullopt;
}

fs::path cacheFolder() {
  if (const char* xdg = std::getenv("XDG_CACHE_HOME"); xdg && fs::path(xdg).is_absolute())
    return fs::path(xdg) / "lodestream";
  if (const char* home = std::getenv("HOME"); home && *home) return fs::path(home) / ".cache" / "lodestream";
  return fs::temp_directory_path() / ("lodestream-" + std::to_string(getuid()));
}

fs::path storesFolder() { return cacheFolder() / "stores"; }

fs::path ownCacheFolder() {
  fs::path folder = cacheFolder();
  refuseForeignFolder(folder, kCacheFolderUse);
  return folder;
}

uint64_t storeCacheBytes(uint64_t disk_bytes) noexcept {
  return std::min(std::max(kLeastBytes, disk_bytes / kShareOfDisk), disk_bytes / 2);
}

uint64_t storeCacheBytes(const fs::path& stores) {
  std::error_code failed;
  const fs::space_info disk = fs::space(stores, failed);
  return failed ? kLeastBytes : storeCacheBytes(uint64_t{disk.capacity});
}

FileLock useStore(const fs::path& store) {
  std::error_code ignored;
  fs::last_write_time(store.parent_path() / kBuildRecord, fs::file_time_type::clock::now(), ignored);
  auto lock = FileLock::tryTake(store, FileLock::Kind::kShared, false);
  return lock ? std::move(*lock) : FileLock();
}

void trimStores(const fs::path& stores, uint64_t max_bytes) {
  std::vector<BuiltSource> sources;
  uint64_t bytes = 0;
  std::error_code failed;
  if (!isOwnFolder(stores)) return;
  for (fs::directory_iterator entry(stores, failed), end; !failed && entry != end; entry.increment(failed)) {
    if (!isOwnFolder(entry->path())) continue;  // never remove files through a link
    sources.push_back(lookAt(entry->path()));
    bytes += sources.back().bytes;
  }
  std::ranges::sort(sources, {}, &BuiltSource::used);
  for (const BuiltSource& source : sources) {
    if (bytes <= max_bytes) return;
    if (remove(source)) bytes -= source.bytes;
  }
}

}  // namespace lode::app
