#pragma once

#include <filesystem>
#include <span>
#include <string_view>

#include "common/io/interrupted.h"
#include "server/ingest/disk/temporary_folder.h"

namespace lode::ingest {

/// Paths of a build whose temporary files lie in the folder of the output.
struct BuildFiles {
  std::filesystem::path journal;
  std::filesystem::path folder;  ///< temporary files

  static BuildFiles of(const std::filesystem::path& output);
};

/// Folder `.OUT.lode.building` beside the output. It holds a lock, the journal and the incomplete store, from
/// which a later build can resume. It also holds the temporary files, unless the caller names another parent
/// folder for them, where they get a subfolder named after a hash of the output's path. After keep(false),
/// the destructor removes everything, the journal and the lock last. Otherwise it keeps the folder.
class BuildFolder {
 public:
  /// Creates and locks the folder. @throws Error kIo if the folder cannot be created or locked, or if another
  /// process builds the same output.
  BuildFolder(const std::filesystem::path& output, const std::filesystem::path& temporary_parent);
  ~BuildFolder();
  BuildFolder(const BuildFolder&) = delete;
  BuildFolder& operator=(const BuildFolder&) = delete;

  std::filesystem::path journal() const { return path_ / "journal"; }
  std::filesystem::path store() const { return path_ / "store"; }

  /// Removes the journal, the store and the temporary files of earlier builds. Removes temporary files both
  /// from `temporary_parent` and from the parent that was passed to the constructor.
  void clear(const std::filesystem::path& temporary_parent);
  /// Opens the folder of temporary files, and creates it if it is missing.
  TemporaryFolder openFiles();
  /// Removes all temporary files except the files with the given names.
  void removeFilesBut(std::span<const std::string_view> names) const;
  /// Syncs to disk the directory entries of the store, the journal and the folder of temporary files.
  /// @throws Error kIo.
  void syncFolders() const;
  /// Syncs the directory entries of the temporary files to disk. @throws Error kIo.
  void syncFiles() const;
  void keep(bool is_kept) noexcept { is_kept_ = is_kept; }
  /// Makes a signal that ends the process remove all files too.
  void removeWhenInterrupted();

 private:
  std::filesystem::path filesIn(const std::filesystem::path& temporary_parent) const;
  void lock();

  std::filesystem::path output_, output_folder_, path_, files_;
  int lock_ = -1;
  bool is_kept_ = true;
  Unfinished unfinished_files_, unfinished_;  ///< set by removeWhenInterrupted()
};

}  // namespace lode::ingest
