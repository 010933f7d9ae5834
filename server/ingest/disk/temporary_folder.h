#pragma once

#include <filesystem>
#include <string_view>

#include "common/io/interrupted.h"
#include "server/ingest/disk/spool.h"

namespace lode::ingest {

/// Words for an error: purpose of a folder, and remedy if it cannot be made.
struct FolderUse {
  const char *what, *remedy;
};

/// Makes a folder that only this user can write to, or accepts an existing one. Rejects links and folders of
/// other users, who could redirect the files. @throws Error kIo.
void makeOwnFolder(const std::filesystem::path& path, const FolderUse& use);

/// A folder for temporary files.
class TemporaryFolder {
 public:
  /// Makes a new folder in `parent`. It is removed with its files by the destructor, or when a signal ends
  /// the process. @throws Error kIo.
  explicit TemporaryFolder(const std::filesystem::path& parent);

  /// Makes or opens a folder at `path` that outlives this object, as its lasting files do. @throws Error kIo,
  /// also if others can write to it.
  static TemporaryFolder lasting(std::filesystem::path path);

  ~TemporaryFolder();
  TemporaryFolder(TemporaryFolder&& other) noexcept;
  TemporaryFolder& operator=(TemporaryFolder&&) = delete;

  const std::filesystem::path& path() const noexcept { return path_; }
  /// A file that its Spool removes.
  TemporaryFile file(std::string_view name) const { return {path_ / name, false}; }
  /// A file that outlives its Spool if this folder is lasting.
  TemporaryFile lastingFile(std::string_view name) const { return {path_ / name, is_lasting_}; }

 private:
  TemporaryFolder() = default;

  std::filesystem::path path_;
  Unfinished unfinished_;  ///< empty if lasting
  bool is_lasting_ = false;
};

}  // namespace lode::ingest
