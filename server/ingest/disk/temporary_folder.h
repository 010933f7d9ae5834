#pragma once

#include <filesystem>
#include <string_view>

#include "common/io/interrupted.h"
#include "server/ingest/disk/spool.h"

namespace lode::ingest {

class TemporaryFolder {
 public:
  /// Creates a new folder in `parent`. The destructor, or a signal that ends the process, removes the folder
  /// and its files. @throws Error kIo.
  explicit TemporaryFolder(const std::filesystem::path& parent);

  /// Opens the folder at `path`, and creates it if it is missing. The folder and the files that lastingFile()
  /// returns outlive this object. @throws Error kIo, also if other users can write to the folder.
  static TemporaryFolder lasting(std::filesystem::path path);

  ~TemporaryFolder();
  TemporaryFolder(TemporaryFolder&& other) noexcept;
  TemporaryFolder& operator=(TemporaryFolder&&) = delete;

  const std::filesystem::path& path() const noexcept { return path_; }
  /// Returns a file that its Spool removes.
  TemporaryFile file(std::string_view name) const { return {path_ / name, false}; }
  /// Returns a file that outlives its Spool if this folder is lasting.
  TemporaryFile lastingFile(std::string_view name) const { return {path_ / name, is_lasting_}; }

 private:
  TemporaryFolder() = default;

  std::filesystem::path path_;
  Unfinished unfinished_;  ///< lets a signal remove the folder; empty if the folder is lasting
  bool is_lasting_ = false;
};

}  // namespace lode::ingest
