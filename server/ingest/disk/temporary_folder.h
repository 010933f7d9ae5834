#pragma once

#include <filesystem>
#include <string_view>

#include "common/io/interrupted.h"
#include "server/ingest/disk/spool.h"

namespace lode::ingest {

/// A folder for temporary files.
class TemporaryFolder {
 public:
  /// Creates a new folder in `parent`. The folder and its files are removed by the destructor, or when a
  /// signal ends the process. @throws Error kIo.
  explicit TemporaryFolder(const std::filesystem::path& parent);

  /// Creates or opens a folder at `path`. The folder and its lasting files outlive this object. @throws Error
  /// kIo, also if other users can write to the folder.
  static TemporaryFolder lasting(std::filesystem::path path);

  ~TemporaryFolder();
  TemporaryFolder(TemporaryFolder&& other) noexcept;
  TemporaryFolder& operator=(TemporaryFolder&&) = delete;

  const std::filesystem::path& path() const noexcept { return path_; }
  /// Returns a file that the Spool removes.
  TemporaryFile file(std::string_view name) const { return {path_ / name, false}; }
  /// Returns a file that outlives the Spool if this folder is lasting.
  TemporaryFile lastingFile(std::string_view name) const { return {path_ / name, is_lasting_}; }

 private:
  TemporaryFolder() = default;

  std::filesystem::path path_;
  Unfinished unfinished_;  ///< the folder to remove; empty if the folder is lasting
  bool is_lasting_ = false;
};

}  // namespace lode::ingest
