#pragma once

#include <filesystem>
#include <set>
#include <string>

namespace lode {

/// Names for the image files beside a mesh's file: STEM_NAME.png, where STEM is that file's and NAME the
/// texture's without folders and ending. No two are the same.
class ImageNames {
 public:
  explicit ImageNames(const std::filesystem::path& mesh) : stem_(mesh.stem().string()) {}

  std::string next(const std::string& texture_name);

 private:
  std::string stem_;
  std::set<std::string> taken_;
};

}  // namespace lode
