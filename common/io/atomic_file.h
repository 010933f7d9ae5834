#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "common/io/interrupted.h"
#include "common/io/output_target.h"

namespace lode {

/// Writes a file under a temporary name; commit() syncs the file and renames it. Without commit(), the
/// destructor or a signal that ends the process removes the temporary file. If the path is a symbolic link,
/// replaces the file to which the link points. Writes to a pipe or a character device directly. Buffers all
/// writes. Not thread safe. All functions throw Error kIo with the file's name.
class AtomicFile {
 public:
  /// @param temporary  name of the temporary file, on the file system of `path`. An existing file of this
  /// name is overwritten, and signals do not remove the temporary file. By default AtomicFile chooses a new
  /// name beside `path`.
  /// @throws Error kIo, and the errors of findOutput() or findSideFile().
  explicit AtomicFile(std::filesystem::path path, std::filesystem::path temporary = {},
                      OutputName name = OutputName::kTyped);
  ~AtomicFile();
  AtomicFile(AtomicFile&& other) noexcept;
  AtomicFile& operator=(AtomicFile&&) = delete;

  void write(std::span<const std::byte> bytes);
  /// Overwrites bytes that were already written; cannot be used for a pipe.
  void writeAt(uint64_t offset, std::span<const std::byte> bytes);
  uint64_t size() const noexcept;
  void commit();

 private:
  void flush();
  std::filesystem::path path_;       ///< path as the caller passed it
  std::filesystem::path target_;     ///< file to replace; empty for a pipe or device
  std::filesystem::path temporary_;  ///< temporary file; empty for a pipe or device, and after commit()
  Unfinished unfinished_;
  int file_ = -1;
  uint64_t size_ = 0;
  std::string buffer_;
};

}  // namespace lode
