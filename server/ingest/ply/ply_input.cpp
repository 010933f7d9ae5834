#include "server/ingest/ply/ply_input.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <optional>
#include <span>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/error.h"
#include "common/io/file_io.h"
#include "common/printable.h"

namespace lode::ingest {

PlyInput::PlyInput(const std::filesystem::path& path) : name_(quotedText(path.string(), 4096)) {
  file_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (file_ < 0) {
    throw Error(ErrorCode::kIo, "cannot open " + name_ + ": " + std::strerror(errno) +
                                    "; check the name and the permissions");
  }
  struct stat status {};
  if (::fstat(file_, &status) != 0 || !S_ISREG(status.st_mode)) {
    const bool directory = S_ISDIR(status.st_mode);
    ::close(file_);
    throw Error(ErrorCode::kIo,
                name_ + (directory ? " is a directory; name the PLY file inside it"
                                   : " is not a regular file; save the PLY to disk first, since "
                                     "it is read more than once"));
  }
  size_ = static_cast<uint64_t>(status.st_size);
  capacity_ = static_cast<size_t>(std::min<uint64_t>(kBufferBytes, std::max<uint64_t>(size_, 1)));
  buffer_ = std::make_unique_for_overwrite<char[]>(capacity_);
  (void)::posix_fadvise(file_, 0, 0, POSIX_FADV_SEQUENTIAL);
}

PlyInput::~PlyInput() { ::close(file_); }

void PlyInput::seek(uint64_t offset) {
  if (offset >= window_offset_ && offset <= window_offset_ + end_) {
    begin_ = static_cast<size_t>(offset - window_offset_);
    return;
  }
  window_offset_ = offset;
  begin_ = end_ = 0;
}

bool PlyInput::refill(size_t n) {
  if (n > remaining()) return false;
  std::memmove(buffer_.get(), buffer_.get() + begin_, available());
  window_offset_ += begin_;
  end_ -= begin_;
  begin_ = 0;
  if (end_ >= n) return true;
  const uint64_t offset = window_offset_ + end_;
  const auto wanted = static_cast<size_t>(std::min<uint64_t>(capacity_ - end_, size_ - offset));
  const std::optional<size_t> got =
      readAt(file_, offset, std::as_writable_bytes(std::span(buffer_.get() + end_, wanted)));
  if (!got) {
    throw Error(ErrorCode::kIo, "cannot read " + name_ + " at byte " + std::to_string(offset) + ": " +
                                    std::strerror(errno) + "; check the disk");
  }
  if (*got < wanted) {
    throw Error(ErrorCode::kIo, name_ + " was truncated during reading, at byte " +
                                    std::to_string(offset + *got) + "; try again when it is complete");
  }
  end_ += *got;
  return true;
}

}  // namespace lode::ingest
