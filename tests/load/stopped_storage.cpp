/// Preload it to stop the storage of the files whose path contains STOPPED_STORAGE. The file that
/// STOPPED_STORAGE_MODE names contains the mode: "eio" fails reads, "hang" blocks reads and fstat() until the
/// mode changes, and anything else lets them pass. Like a network mount, such a file rejects RWF_NOWAIT.
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

namespace {

constexpr useconds_t kPollMicroseconds = 5000;

template <typename Function>
Function* systemFunction(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

bool isStoppable(int file) {
  static const char* const part = std::getenv("STOPPED_STORAGE");
  char link[64], path[4096];
  std::snprintf(link, sizeof link, "/proc/self/fd/%d", file);
  const ssize_t bytes = ::readlink(link, path, sizeof path - 1);
  if (part == nullptr || bytes < 0) return false;
  path[bytes] = '\0';
  return std::strstr(path, part) != nullptr;
}

bool modeIs(const char* wanted) {
  static const char* const name = std::getenv("STOPPED_STORAGE_MODE");
  char mode[16] = "";
  const int file = name == nullptr ? -1 : ::open(name, O_RDONLY | O_CLOEXEC);
  const ssize_t bytes = file < 0 ? 0 : ::read(file, mode, sizeof mode - 1);
  if (file >= 0) ::close(file);
  return bytes > 0 && std::strncmp(mode, wanted, std::strlen(wanted)) == 0;
}

void waitWhileHanging() {
  while (modeIs("hang")) ::usleep(kPollMicroseconds);
}

/// Waits while the storage hangs. @return false, with errno set, if the storage fails.
bool storageAnswers(int file) {
  if (!isStoppable(file)) return true;
  waitWhileHanging();
  if (!modeIs("eio")) return true;
  errno = EIO;
  return false;
}

}  // namespace

extern "C" {

ssize_t pread(int file, void* into, size_t bytes, off_t offset) {
  static auto* const next = systemFunction<ssize_t(int, void*, size_t, off_t)>("pread");
  return storageAnswers(file) ? next(file, into, bytes, offset) : -1;
}

ssize_t pread64(int file, void* into, size_t bytes, off64_t offset) {
  static auto* const next = systemFunction<ssize_t(int, void*, size_t, off64_t)>("pread64");
  return storageAnswers(file) ? next(file, into, bytes, offset) : -1;
}

ssize_t preadv2(int file, const iovec* into, int count, off_t offset, int flags) {
  static auto* const next = systemFunction<ssize_t(int, const iovec*, int, off_t, int)>("preadv2");
  if (flags == 0 || !isStoppable(file)) return next(file, into, count, offset, flags);
  errno = EOPNOTSUPP;
  return -1;
}

int fstat(int file, struct stat* into) {
  static auto* const next = systemFunction<int(int, struct stat*)>("fstat");
  if (isStoppable(file)) waitWhileHanging();  // like a mount that remembers the status of its files
  return next(file, into);
}
}
