#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <type_traits>
#include <vector>

namespace lode::ingest {

/// A temporary file: written once from front to end, then read in any order. Removed at destruction.
/// Appending and flushing are for one thread at a time; readAt is thread safe once the file is flushed.
/// All functions throw Error kIo; a full disk is named as such.
class Spool {
 public:
  explicit Spool(std::filesystem::path path);
  ~Spool();
  Spool(Spool&& other) noexcept;
  Spool& operator=(Spool&&) = delete;

  void append(std::span<const std::byte> bytes);
  template <typename T>
  requires std::is_trivially_copyable_v<T>
  void append(std::span<const T> items) { append(std::as_bytes(items)); }
  /// Writes what is held back, and lets go of the buffer.
  void flush();

  /// Bytes appended so far.
  uint64_t size() const noexcept { return size_; }
  /// Fills `bytes` from the given offset. Flushed bytes only.
  void readAt(uint64_t offset, std::span<std::byte> bytes) const;

 private:
  void writeBuffer();

  std::filesystem::path path_;
  int file_ = -1;
  uint64_t size_ = 0;
  std::vector<std::byte> buffer_;
};

/// Reads a flushed spool, or a part of it, from front to end in large steps. For one thread.
class SpoolCursor {
 public:
  SpoolCursor(const Spool& spool, uint64_t begin, uint64_t end, size_t buffer_bytes = 1 << 20);

  bool atEnd() const noexcept { return next_ == end_ && used_ == buffer_.size(); }
  /// The next bytes, valid until the next call; fewer than asked only at the end.
  std::span<const std::byte> take(size_t bytes);
  template <typename T>
  requires std::is_trivially_copyable_v<T>
  void take(std::span<T> items) { copyTo(std::as_writable_bytes(items)); }

 private:
  void copyTo(std::span<std::byte> bytes);

  const Spool* spool_;
  uint64_t next_, end_;
  size_t buffer_bytes_;
  std::vector<std::byte> buffer_;
  size_t used_ = 0;
};

}  // namespace lode::ingest
