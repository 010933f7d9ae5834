#pragma once

#include <filesystem>
#include <span>
#include <string_view>

#include "server/ingest/disk/temporary_folder.h"

namespace lode::ingest {

/// Where a build of an output keeps what a later one can go on from: `.OUT.lode.building` beside the output,
/// with a lock, the journal, and the store until it is complete. The temporary files lie in it, or, if
/// another place was named for them, there in a folder whose name follows from the output's. Locked as long
/// as it lives. At destruction all is removed unless it is kept, the journal last but the lock.
class BuildFolder {
 public:
  /// Kept until the caller says otherwise. @throws Error kIo if it cannot be made, or if another process
  /// builds the same output.
  BuildFolder(const std::filesystem::path& output, const std::filesystem::path& temporary_parent);
  ~BuildFolder();
  BuildFolder(const BuildFolder&) = delete;
  BuildFolder& operator=(const BuildFolder&) = delete;

  std::filesystem::path journal() const { return path_ / "journal"; }
  std::filesystem::path store() const { return path_ / "store"; }

  /// Removes what builds left that had their temporary files in `temporary_parent`, or in this one's.
  void clear(const std::filesystem::path& temporary_parent);
  /// The temporary files' folder, made if it is not there.
  TemporaryFolder openFiles();
  /// Removes all temporary files but these.
  void removeFilesBut(std::span<const std::string_view> names) const;
  /// Return when the names of all folders, or of the temporary files, are on the disk. @throws Error kIo.
  void syncFolders() const;
  void syncFiles() const;
  void keep(bool is_kept) noexcept { is_kept_ = is_kept; }

 private:
  std::filesystem::path filesIn(const std::filesystem::path& temporary_parent) const;
  void lock();

  std::filesystem::path output_, output_folder_, path_, files_;
  int lock_ = -1;
  bool is_kept_ = true;
};

}  // namespace lode::ingest
