#pragma once

#include <filesystem>
#include <span>
#include <string_view>

#include "common/io/interrupted.h"
#include "server/ingest/disk/temporary_folder.h"

namespace lode::ingest {

/// Folder `.OUT.lode.building` beside the output. The folder contains a lock, the journal and the incomplete
/// store, from which a later build can resume. The folder also contains the temporary files, unless the
/// caller names another parent for temporary files. The parent then gets a subfolder for temporary files,
/// named after the output. Unless keep(true) was called, the destructor removes all files; journal and lock
/// go last.
class BuildFolder {
 public:
  /// Creates and locks the folder; keep() is true at first. @throws Error kIo if the folder cannot be created
  /// or locked, or if another process builds the same output.
  BuildFolder(const std::filesystem::path& output, const std::filesystem::path& temporary_parent);
  ~BuildFolder();
  BuildFolder(const BuildFolder&) = delete;
  BuildFolder& operator=(const BuildFolder&) = delete;

  std::filesystem::path journal() const { return path_ / "journal"; }
  std::filesystem::path store() const { return path_ / "store"; }

  /// Removes journal, store and temporary files of earlier builds. Temporary files are removed in
  /// `temporary_parent` and in this build's folder.
  void clear(const std::filesystem::path& temporary_parent);
  /// Opens the folder of temporary files. Creates the folder if it is missing.
  TemporaryFolder openFiles();
  /// Removes all temporary files except the files with the given names.
  void removeFilesBut(std::span<const std::string_view> names) const;
  /// Syncs the entries of all folders to disk. @throws Error kIo.
  void syncFolders() const;
  /// Syncs the entries of temporary files to disk. @throws Error kIo.
  void syncFiles() const;
  void keep(bool is_kept) noexcept { is_kept_ = is_kept; }
  /// Removes all files also if a signal ends the process.
  void removeWhenInterrupted();

 private:
  std::filesystem::path filesIn(const std::filesystem::path& temporary_parent) const;
  void lock();

  std::filesystem::path output_, output_folder_, path_, files_;
  int lock_ = -1;
  bool is_kept_ = true;
  Unfinished unfinished_files_, unfinished_;  ///< marks of removeWhenInterrupted()
};

}  // namespace lode::ingest
