#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "common/io/folder_index.h"

namespace lode {

/// Image file for a `comment TextureFile` line of a PLY file.
struct TextureFile {
  std::filesystem::path path;  ///< canonical path of a regular file; empty if there is a problem
  std::string problem;         ///< reason why the image cannot be read, and remedy; empty if `path` is set
};

/// Finds the images that a PLY file names. Searches the folder of --textures, the PLY file's folder and, if
/// the PLY file is a link, the folder of the link's target. Never returns a file outside these folders, and
/// follows no link out of them. Takes the first of these that exists:
/// 1. the file at the path in the PLY file,
/// 2. the file at the longest existing end of that path, which may have slashes or backslashes: for
///    `C:\scan\maps\a.png`, maps/a.png if it exists, else a.png,
/// 3. the only file with the path's last component as its name in a subfolder (see FolderIndex), or else the
///    only such file whose name differs only in the case of letters.
/// Lists a folder at most once, at the first image that needs it. Not thread safe.
class TextureFinder {
 public:
  /// @param folder  folder of --textures; may be empty.
  explicit TextureFinder(const std::filesystem::path& ply, const std::filesystem::path& folder = {});
  ~TextureFinder();
  TextureFinder(TextureFinder&&) = delete;
  TextureFinder& operator=(TextureFinder&&) = delete;

  /// @param name  image name in the comment TextureFile.
  TextureFile find(const std::string& name);

 private:
  struct Folder {
    std::filesystem::path path;
    std::unique_ptr<FolderIndex> index = {};
  };

  void addFolder(const std::filesystem::path& folder);
  const FolderIndex& indexOf(Folder& folder);
  TextureFile search(const std::string& last_component);
  std::string notFound(const std::string& last_component);

  std::vector<Folder> folders_;
  const bool has_texture_folder_;
};

}  // namespace lode
