#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

namespace lode::ingest {

/// Reads a file through a sliding buffer. Not thread safe.
class PlyInput {
 public:
  static constexpr size_t kBufferBytes = 4u << 20;

  /// Opens a file. @throws Error kIo if there is no such file or if the path is not a regular file.
  explicit PlyInput(const std::filesystem::path& path);
  ~PlyInput();
  PlyInput(PlyInput&&) = delete;
  PlyInput& operator=(PlyInput&&) = delete;

  const std::string& name() const noexcept { return name_; }  ///< quoted name of the file, for messages
  uint64_t size() const noexcept { return size_; }            ///< size of the file when it was opened
  uint64_t offset() const noexcept { return window_offset_ + begin_; }
  uint64_t remaining() const noexcept { return size_ - offset(); }

  const char* data() const noexcept { return buffer_.get() + begin_; }
  size_t available() const noexcept { return end_ - begin_; }  ///< number of bytes at data()
  /// Reads until n bytes (at most kBufferBytes) are available at data(). The pointer that data() returns can
  /// change.
  /// @return false if the file ends before that.
  bool fill(size_t n) { return available() >= n || refill(n); }
  /// Skips n bytes, n <= available().
  void consume(size_t n) noexcept { begin_ += n; }
  /// Moves to an offset. @param offset  at most size().
  void seek(uint64_t offset);

 private:
  bool refill(size_t n);

  std::string name_;
  int file_ = -1;
  uint64_t size_ = 0;
  uint64_t window_offset_ = 0;  ///< file offset of the buffer's first byte
  size_t capacity_ = 0;
  size_t begin_ = 0;
  size_t end_ = 0;
  std::unique_ptr<char[]> buffer_;
};

}  // namespace lode::ingest
