#include "common/io/file_io.h"

#include <cerrno>
#include <cstring>
#include <system_error>

#include <unistd.h>

#include "common/error.h"

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

void refuseUnlessFile(const std::filesystem::path& path, const char* wanted) {
  std::error_code failed;
  const std::filesystem::file_status status = std::filesystem::status(path, failed);
  if (!std::filesystem::exists(status) || std::filesystem::is_regular_file(status)) return;
  const bool is_folder = std::filesystem::is_directory(status);
  throw Error(ErrorCode::kIo, path.string() + (is_folder ? " is a directory" : " is a pipe or a device") +
                                  "; name " + wanted);
}

std::string fileErrorInWords(int error, const char* when_full) {
  if (error == ENOSPC || error == EDQUOT) return std::string("the disk is full; ") + when_full;
  return std::strerror(error);
}

}  // namespace lode
