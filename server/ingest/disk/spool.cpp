#include "server/ingest/disk/spool.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <optional>
#include <string>
#include <utility>

#include <fcntl.h>
#include <unistd.h>

#include "common/error.h"
#include "common/io/file_io.h"
#include "common/release_storage.h"

namespace lode::ingest {
namespace {

constexpr size_t kWriteBufferBytes = 256 << 10;

[[noreturn]] void failSpool(const std::filesystem::path& path, const char* what) {
  throw Error(
      ErrorCode::kIo,
      std::string("cannot ") + what + " temporary file " + path.string() + ": " +
          fileErrorInWords(errno,
                           "free disk space, or set another folder with --tmp (lodestream: XDG_CACHE_HOME)"));
}

}  // namespace

Spool::Spool(TemporaryFile file) : path_(std::move(file.path)), lasts_(file.lasts) {
  file_ = open(path_.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  if (file_ < 0) failSpool(path_, "create");
}

Spool::Spool(TemporaryFile file, uint64_t size) : Spool(std::move(file), size, O_RDWR) {
  if (ftruncate(file_, static_cast<off_t>(size)) != 0) failSpool(path_, "truncate");
}

Spool Spool::forReading(std::filesystem::path path, uint64_t size) {
  return {TemporaryFile{std::move(path), true}, size, O_RDONLY};
}

Spool::Spool(TemporaryFile file, uint64_t size, int flags)
    : path_(std::move(file.path)), lasts_(file.lasts), size_(size), written_(size) {
  file_ = open(path_.c_str(), flags | O_CLOEXEC);
  if (file_ < 0) failSpool(path_, "open");
  const off_t there = lseek(file_, 0, SEEK_END);
  if (there < 0 || static_cast<uint64_t>(there) < size) {
    close(file_);
    throw Error(ErrorCode::kFormat,
                "temporary file " + path_.string() + " was truncated; build without --resume");
  }
}

Spool::~Spool() {
  if (file_ < 0) return;
  close(file_);
  if (!lasts_) unlink(path_.c_str());
}

Spool::Spool(Spool&& other) noexcept
    : path_(std::move(other.path_)),
      lasts_(other.lasts_),
      file_(std::exchange(other.file_, -1)),
      size_(other.size_),
      written_(other.written_),
      buffer_(std::move(other.buffer_)) {}

void Spool::append(std::span<const std::byte> bytes) {
  size_ += bytes.size();
  buffer_.reserve(kWriteBufferBytes);
  while (!bytes.empty()) {
    const size_t part = std::min(bytes.size(), kWriteBufferBytes - buffer_.size());
    buffer_.insert(buffer_.end(), bytes.begin(), bytes.begin() + static_cast<ptrdiff_t>(part));
    bytes = bytes.subspan(part);
    if (buffer_.size() == kWriteBufferBytes) writeBuffer();
  }
}

void Spool::flush() {
  writeBuffer();
  releaseStorage(buffer_);
}

void Spool::sync() const {
  if (fdatasync(file_) != 0) failSpool(path_, "sync");
}

void Spool::writeBuffer() {
  if (!lode::writeAt(file_, written_, buffer_)) failSpool(path_, "write");
  written_ += buffer_.size();
  buffer_.clear();
}

void Spool::readAt(uint64_t offset, std::span<std::byte> bytes) const {
  const std::optional<size_t> got = lode::readAt(file_, offset, bytes);
  if (got && *got < bytes.size()) errno = EIO;
  if (got != bytes.size()) failSpool(path_, "read");
}

SpoolCursor::SpoolCursor(const Spool& spool, uint64_t begin, uint64_t end, size_t buffer_bytes)
    : spool_(&spool), next_(begin), end_(end), buffer_bytes_(buffer_bytes) {}

std::span<const std::byte> SpoolCursor::take(size_t bytes) {
  if (buffer_.size() - used_ < bytes) {
    buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<ptrdiff_t>(used_));
    used_ = 0;
    const size_t kept = buffer_.size();
    const size_t wanted = std::max(bytes, buffer_bytes_) - kept;
    const size_t more = static_cast<size_t>(std::min<uint64_t>(wanted, end_ - next_));
    buffer_.resize(kept + more);
    spool_->readAt(next_, std::span(buffer_).subspan(kept));
    next_ += more;
  }
  const size_t given = std::min(bytes, buffer_.size() - used_);
  const std::span<const std::byte> result(buffer_.data() + used_, given);
  used_ += given;
  return result;
}

void SpoolCursor::copyTo(std::span<std::byte> bytes) {
  while (!bytes.empty()) {
    const auto part = take(std::min(bytes.size(), buffer_bytes_));
    if (part.empty()) throw Error(ErrorCode::kInternal, "a temporary file ended too early");
    std::memcpy(bytes.data(), part.data(), part.size());
    bytes = bytes.subspan(part.size());
  }
}

}  // namespace lode::ingest
