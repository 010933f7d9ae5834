#include "server/ingest/soup/input_images.h"

#include <map>
#include <utility>

#include "common/codec/texture_set.h"
#include "common/error.h"
#include "common/io/texture_finder.h"
#include "server/ingest/ply/ply_header.h"

namespace lode::ingest {

std::vector<NamedImage> imagesOf(const std::filesystem::path& ply, std::span<const std::string> names) {
  std::vector<NamedImage> images;
  for (const std::string& name : names) images.push_back({ply, name});
  return images;
}

InputImages listImages(std::span<const std::filesystem::path> inputs,
                       const std::filesystem::path& textures_folder) {
  InputImages result;
  std::map<std::string, uint16_t> numbers;  // by the path of the image
  for (const std::filesystem::path& input : inputs) {
    std::vector<uint16_t>& of_file = result.of_file.emplace_back();
    const PlyHeader header = readPlyHeader(input);
    TextureFinder finder(input, textures_folder);
    for (const std::string& name : header.texture_files) {
      auto number = static_cast<uint16_t>(result.images.size());
      // A file may list one image twice; only images of other files are joined, so that a single file keeps
      // its numbers.
      if (inputs.size() > 1) {
        const TextureFile file = finder.find(name);
        const std::string key = file.problem.empty() ? file.path.string() : input.string() + "\n" + name;
        number = numbers.emplace(key, number).first->second;
      }
      of_file.push_back(number);
      if (number < result.images.size()) continue;
      result.images.push_back({input, name});
      if (result.images.size() > kMaxTextures)
        throw Error(ErrorCode::kInput, input.string() + ": more than " + std::to_string(kMaxTextures) +
                                           " texture files; merge some of them");
    }
  }
  return result;
}

}  // namespace lode::ingest
