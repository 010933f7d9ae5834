#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "common/io/interrupted.h"

namespace lode {

/// A file that appears under its name only when commit() has synced and renamed it; destroyed before, it
/// leaves nothing behind. Links are followed: what they lead to is replaced. A pipe or a character device is
/// written straight. Nothing is left of it either if a signal ends the process. Writes are buffered. Not
/// thread safe. All functions throw Error kIo naming the file and, for a full disk, saying so.
class AtomicFile {
 public:
  /// @param temporary  where it is written, on the file system of `path`, over what may be there; by default
  /// a new name beside it. What is given stays when a signal ends the process, for its owner.
  /// @throws also as findOutput().
  explicit AtomicFile(std::filesystem::path path, std::filesystem::path temporary = {});
  ~AtomicFile();
  AtomicFile(AtomicFile&& other) noexcept;
  AtomicFile& operator=(AtomicFile&&) = delete;

  void write(std::span<const std::byte> bytes);
  void writeAt(uint64_t offset,
               std::span<const std::byte> bytes);  ///< over what was written already; not in a pipe
  uint64_t size() const noexcept;
  void commit();

 private:
  void flush();
  std::filesystem::path path_;       ///< as it was asked for
  std::filesystem::path target_;     ///< that is replaced; empty if it is written straight
  std::filesystem::path temporary_;  ///< empty if there is none, or none any more
  Unfinished unfinished_;
  int file_ = -1;
  uint64_t size_ = 0;
  std::string buffer_;
};

}  // namespace lode
