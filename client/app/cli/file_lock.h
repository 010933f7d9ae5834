#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

namespace lode::app {

/// A lock on a file that programs agree by (flock); it ends with its object, or with the process and those
/// that have inherited its descriptor. Move only.
class FileLock {
 public:
  enum class Kind : uint8_t { kShared, kExclusive };

  FileLock() = default;  ///< of nothing
  ~FileLock();
  FileLock(FileLock&& other) noexcept;
  FileLock& operator=(FileLock&& other) noexcept;

  /// @param make  the file, where it is missing.
  /// @return nothing while another has it, or the file was replaced meanwhile, with an errno of 0; or where
  /// it cannot be opened or locked at all, which errno then says.
  static std::optional<FileLock> tryTake(const std::filesystem::path& path, Kind kind, bool make);

  int descriptor() const noexcept { return file_; }

 private:
  int file_ = -1;
};

}  // namespace lode::app
