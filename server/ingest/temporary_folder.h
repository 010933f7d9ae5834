#pragma once

#include <filesystem>
#include <string_view>

namespace lode::ingest {

/// A folder of a build's temporary files, made at construction and removed, with what is in it, at
/// destruction.
class TemporaryFolder {
 public:
  /// @throws Error kIo if the folder cannot be made there.
  explicit TemporaryFolder(const std::filesystem::path& parent);
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  std::filesystem::path file(std::string_view name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

}  // namespace lode::ingest
