#include "common/io/file_io.h"

#include <cerrno>
#include <cstring>

#include <unistd.h>

namespace lode {

std::optional<size_t> readAt(int file, uint64_t offset, std::span<std::byte> bytes) noexcept {
  size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t got =
        ::pread(file, bytes.data() + done, bytes.size() - done, static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return std::nullopt;
    if (got == 0) break;
    done += static_cast<size_t>(got);
  }
  return done;
}

bool writeAt(int file, uint64_t offset, std::span<const std::byte> bytes) noexcept {
  for (size_t done = 0; done < bytes.size();) {
    const ssize_t more =
        ::pwrite(file, bytes.data() + done, bytes.size() - done, static_cast<off_t>(offset + done));
    if (more < 0 && errno == EINTR) continue;
    if (more < 0) return false;
    done += static_cast<size_t>(more);
  }
  return true;
}

bool append(int file, std::span<const std::byte> bytes) noexcept {
  while (!bytes.empty()) {
    const ssize_t more = ::write(file, bytes.data(), bytes.size());
    if (more < 0 && errno == EINTR) continue;
    if (more < 0) return false;
    bytes = bytes.subspan(static_cast<size_t>(more));
  }
  return true;
}

std::string fileErrorInWords(int error, const char* when_full) {
  if (error == ENOSPC || error == EDQUOT) return std::string("the disk is full; ") + when_full;
  return std::strerror(error);
}

}  // namespace lode
