#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <type_traits>
#include <vector>

namespace lode::ingest {

/// Name of a temporary file.
struct TemporaryFile {
  std::filesystem::path path;
  bool lasts = false;  ///< it stays when its Spool goes: for a build to go on from
};

/// A temporary file: written once from front to end, then read in any order. Removed at destruction, unless
/// it lasts. Appending and flushing are for one thread at a time; readAt is thread safe once the file is
/// flushed. All functions throw Error kIo; a full disk is named as such.
class Spool {
 public:
  /// An empty one, over what a killed build may have left under that name.
  explicit Spool(TemporaryFile file);
  /// The first `size` bytes of one that a killed build wrote; more is appended behind them. @throws Error
  /// kFormat if it is shorter.
  Spool(TemporaryFile file, uint64_t size);
  ~Spool();
  Spool(Spool&& other) noexcept;
  Spool& operator=(Spool&&) = delete;

  void append(std::span<const std::byte> bytes);
  template <typename T>
  requires std::is_trivially_copyable_v<T>
  void append(std::span<const T> items) { append(std::as_bytes(items)); }
  /// Writes what is held back, and lets go of the buffer.
  void flush();
  /// Returns when what was flushed is on the disk. Thread safe.
  void sync() const;

  /// Bytes appended so far.
  uint64_t size() const noexcept { return size_; }
  /// Fills `bytes` from the given offset. Flushed bytes only.
  void readAt(uint64_t offset, std::span<std::byte> bytes) const;

 private:
  void writeBuffer();

  std::filesystem::path path_;
  bool lasts_ = false;
  int file_ = -1;
  uint64_t size_ = 0;
  uint64_t written_ = 0;  ///< of these; the rest is in the buffer
  std::vector<std::byte> buffer_;
};

/// Reads a flushed spool, or a part of it, from front to end in large steps. For one thread.
class SpoolCursor {
 public:
  SpoolCursor(const Spool& spool, uint64_t begin, uint64_t end, size_t buffer_bytes = 1 << 20);

  /// Offset in the spool of what take() gives next.
  uint64_t offset() const noexcept { return next_ - (buffer_.size() - used_); }
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
