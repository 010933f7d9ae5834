#include "client/app/cli/file_lock.h"

#include <cerrno>
#include <utility>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

namespace lode::app {

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
  lock.file_ = make ? open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600)
                    : open(path.c_str(), O_RDONLY | O_CLOEXEC);
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

}  // namespace lode::app
