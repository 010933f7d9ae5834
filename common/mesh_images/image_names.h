#pragma once

#include <filesystem>
#include <set>
#include <string>

namespace lode {

/// Makes unique names for the image files beside a mesh file: STEM_NAME.png. STEM is the stem of the mesh
/// file, NAME is the texture's name without folders and extension.
class ImageNames {
 public:
  explicit ImageNames(const std::filesystem::path& mesh) : stem_(mesh.stem().string()) {}

  std::string next(const std::string& texture_name);

 private:
  std::string stem_;
  std::set<std::string> taken_;
};

}  // namespace lode
