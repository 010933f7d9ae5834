#pragma once

#include <filesystem>
#include <string_view>

#include "common/io/interrupted.h"
#include "server/ingest/disk/spool.h"

namespace lode::ingest {

/// What a folder is for, and what to do where it cannot be made: words of an error.
struct FolderUse {
  const char *what, *remedy;
};

/// Makes a folder that none but this user can write to, unless it is there. A link in its place, or another
/// user's folder, would have files written wherever that user likes. @throws Error kIo.
void makeOwnFolder(const std::filesystem::path& path, const FolderUse& use);

/// A folder for temporary files.
class TemporaryFolder {
 public:
  /// One of its own in `parent`, removed with what is in it at destruction, or when a signal ends
  /// the process.
  /// @throws Error kIo if it cannot be made there.
  explicit TemporaryFolder(const std::filesystem::path& parent);

  /// One under a name of its owner's choice, which may be there already and outlives this object, as its
  /// lasting files do. @throws Error kIo, also if what is there is no folder of this user's alone.
  static TemporaryFolder lasting(std::filesystem::path path);

  ~TemporaryFolder();
  TemporaryFolder(TemporaryFolder&& other) noexcept;
  TemporaryFolder& operator=(TemporaryFolder&&) = delete;

  const std::filesystem::path& path() const noexcept { return path_; }
  /// A file that goes with its Spool.
  TemporaryFile file(std::string_view name) const { return {path_ / name, false}; }
  /// In a lasting folder a file that stays when its Spool goes.
  TemporaryFile lastingFile(std::string_view name) const { return {path_ / name, is_lasting_}; }

 private:
  TemporaryFolder() = default;

  std::filesystem::path path_;
  Unfinished unfinished_;  ///< unless it is lasting
  bool is_lasting_ = false;
};

}  // namespace lode::ingest
