#include "client/app/cli/cut_images.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include <glm/glm.hpp>

#include "client/app/cli/resident_image.h"
#include "common/io/mesh_materials.h"
#include "common/io/output_target.h"
#include "common/mesh_images/image_names.h"
#include "common/mesh_images/png_writer.h"

namespace lode::app {

CutImages writeCutImages(const core::Cut& cut, const Mesh& mesh, const std::filesystem::path& mesh_file) {
  CutImages images;
  if (!cut.textures || cut.textures->textures.empty()) return images;
  refuseFilesBesideStream(mesh_file);
  TextureSet& set = images.files.set;
  set = *cut.textures;
  ImageNames names(mesh_file);
  std::vector<bool> is_written(set.textures.size());
  images.files.has_alpha.resize(set.textures.size());
  for (const MaterialGroup& group : groupByMaterial(mesh)) {
    if (imageOf(mesh, set, group.material).empty()) continue;
    Texture& texture = set.textures[group.material];
    const ResidentImage image(cut.textures->textures[group.material], group.material, cut.tiles);
    if (!image.isThere()) {
      images.left_out.push_back(texture.name);
      continue;
    }
    const std::string name = names.next(texture.name);
    const bool has_alpha = image.hasAlpha();
    writePng(mesh_file.parent_path() / name, image.size(), has_alpha,
             [&](uint32_t y, std::span<glm::u8vec4> row) { image.fill(y, row); });
    texture.name = name;
    is_written[group.material] = true;
    images.files.has_alpha[group.material] = has_alpha;
  }
  for (size_t i = 0; i < is_written.size(); ++i)
    if (!is_written[i]) set.textures[i].width = set.textures[i].height = 0;
  return images;
}

}  // namespace lode::app
