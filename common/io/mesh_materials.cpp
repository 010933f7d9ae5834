#include "common/io/mesh_materials.h"

#include <map>

namespace lode {

std::vector<MaterialGroup> groupByMaterial(const Mesh& mesh) {
  const bool has_materials = mesh.attributes.has(AttributeSet::kMaterial);
  std::map<uint16_t, std::vector<uint32_t>> triangles_of;
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    const uint16_t material = has_materials ? mesh.vertex_attributes[mesh.triangles[i].x].material : 0;
    triangles_of[material].push_back(static_cast<uint32_t>(i));
  }
  std::vector<MaterialGroup> groups;
  groups.reserve(triangles_of.size());
  for (auto& [material, triangles] : triangles_of) groups.push_back({material, std::move(triangles)});
  return groups;
}

std::string imageOf(const Mesh& mesh, const TextureSet& textures, uint16_t material) {
  if (!mesh.attributes.has(AttributeSet::kTexture) || material >= textures.textures.size()) return {};
  const Texture& texture = textures.textures[material];
  return texture.width == 0 ? std::string() : texture.name;
}

}  // namespace lode
