#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <type_traits>
#include <vector>

namespace lode::ingest {

/// Path of a temporary file, and whether the file outlives its Spool.
struct TemporaryFile {
  std::filesystem::path path;
  /// True if the file outlives its Spool, so that a later build can resume from the file.
  bool lasts = false;
};

/// A temporary file. Append bytes, call flush(), then read them at any offset. The destructor removes the
/// file unless TemporaryFile::lasts is set. Only one thread at a time can append or flush; readAt() is thread
/// safe after flush(). All functions throw Error kIo; the message says so if the disk is full.
class Spool {
 public:
  /// Creates an empty file. Replaces an existing file.
  explicit Spool(TemporaryFile file);
  /// Opens the file of an earlier build and truncates it to `size` bytes. append() continues at that offset.
  /// @throws Error kFormat if the file is shorter.
  Spool(TemporaryFile file, uint64_t size);
  /// Opens the first `size` bytes of another build's file for readAt() only, and keeps the file.
  /// @throws Error kFormat if the file is shorter.
  static Spool forReading(std::filesystem::path path, uint64_t size);
  ~Spool();
  Spool(Spool&& other) noexcept;
  Spool& operator=(Spool&&) = delete;

  void append(std::span<const std::byte> bytes);
  template <typename T>
  requires std::is_trivially_copyable_v<T>
  void append(std::span<const T> items) { append(std::as_bytes(items)); }
  /// Writes the buffer to the file and frees the buffer.
  void flush();
  /// Syncs flushed bytes to disk. Thread safe.
  void sync() const;

  /// Returns the number of bytes appended so far.
  uint64_t size() const noexcept { return size_; }
  /// Fills `bytes` from the file at `offset`. @pre these bytes were flushed.
  void readAt(uint64_t offset, std::span<std::byte> bytes) const;

 private:
  Spool(TemporaryFile file, uint64_t size, int flags);
  void writeBuffer();

  std::filesystem::path path_;
  bool lasts_ = false;
  int file_ = -1;
  uint64_t size_ = 0;
  uint64_t written_ = 0;  ///< number of bytes in the file; the rest are in buffer_
  std::vector<std::byte> buffer_;
};

/// Reads a range of a flushed spool sequentially through a buffer. Not thread safe.
class SpoolCursor {
 public:
  SpoolCursor(const Spool& spool, uint64_t begin, uint64_t end, size_t buffer_bytes = 1 << 20);

  /// Returns the offset of the next byte that take() will return.
  uint64_t offset() const noexcept { return next_ - (buffer_.size() - used_); }
  bool atEnd() const noexcept { return next_ == end_ && used_ == buffer_.size(); }
  /// Returns the next `bytes` bytes, or fewer at the end of the range. They are valid until the next call.
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
