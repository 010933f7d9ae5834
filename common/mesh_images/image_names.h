#pragma once

#include <filesystem>
#include <set>
#include <string>

namespace lode {

/// Unique names for the image files beside a mesh file: STEM_NAME.png, with the stem of the mesh file and the
/// texture's name without folders and extension.
class ImageNames {
 public:
  explicit ImageNames(const std::filesystem::path& mesh) : stem_(mesh.stem().string()) {}

  std::string next(const std::string& texture_name);

 private:
  std::string stem_;
  std::set<std::string> taken_;
};

}  // namespace lode
