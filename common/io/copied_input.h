#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>

#include "common/io/interrupted.h"

namespace lode {

/// Returns true if the name of an input file stands for standard input: "-" or "/dev/stdin".
bool namesStandardInput(std::string_view name) noexcept;

/// A copy of a PLY file that a program receives through a pipe. A build needs a file, because it compares the
/// header with the size of the file, and reads the body twice if the faces come first.
class CopiedInput {
 public:
  /// Copies the input up to its end into a new folder in `parent`, which only this user can use. The
  /// destructor, or a signal that ends the process, removes the folder.
  /// @param input      descriptor to read from, which stays open.
  /// @param max_bytes  size limit for the copy.
  /// @throws Error kUsage if the input is a terminal, kInput if its first bytes are not those of a PLY file,
  /// kLimit if it is longer than max_bytes, kIo if it cannot be read or the copy cannot be written.
  CopiedInput(int input, const std::filesystem::path& parent, uint64_t max_bytes);
  ~CopiedInput();
  CopiedInput(CopiedInput&&) = delete;
  CopiedInput& operator=(CopiedInput&&) = delete;

  /// Returns the path of the copy.
  const std::filesystem::path& path() const noexcept { return path_; }

 private:
  std::filesystem::path path_;
  Unfinished unfinished_;  ///< lets a signal remove the folder
};

/// Returns the size limit for a copy in a folder: half of the free space, because the build needs as much.
uint64_t copyBytesIn(const std::filesystem::path& folder);

}  // namespace lode
