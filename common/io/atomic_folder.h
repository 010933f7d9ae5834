#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "common/io/interrupted.h"

namespace lode {

/// Writes a folder of files under a temporary name beside the folder; commit() syncs the files and renames
/// the folder. Without commit(), the destructor or a signal that ends the process removes the temporary
/// folder. All functions throw Error kIo with the name of the file or folder.
class AtomicFolder {
 public:
  /// Creates the temporary folder. If the path is a symbolic link, the folder to which it points is written.
  /// @throws Error kUsage if the path exists and is not an empty folder.
  explicit AtomicFolder(const std::filesystem::path& path);
  ~AtomicFolder();
  AtomicFolder(const AtomicFolder&) = delete;
  AtomicFolder& operator=(const AtomicFolder&) = delete;

  /// Creates a subfolder. Not thread safe.
  void makeFolder(const std::filesystem::path& name);
  /// Writes a new file. Thread safe for different names.
  /// @param name  relative path; its folder must exist.
  void write(const std::filesystem::path& name, std::span<const std::byte> bytes) const;
  /// Call it last.
  void commit();

 private:
  std::filesystem::path target_;
  std::filesystem::path temporary_;  ///< empty after commit()
  Unfinished unfinished_;
};

}  // namespace lode
