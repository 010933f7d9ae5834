#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/codec/texture_set.h"
#include "common/mesh.h"

namespace lode {

/// Indices of the triangles of a mesh that have the same material, in the mesh's order.
struct MaterialGroup {
  uint16_t material = 0;
  std::vector<uint32_t> triangles;
};

/// Groups triangles by material, in ascending order of materials. A mesh without materials forms one group of
/// material 0.
std::vector<MaterialGroup> groupByMaterial(const Mesh& mesh);

/// Returns the name of a material's image, or an empty string if the material has no image.
std::string imageOf(const Mesh& mesh, const TextureSet& textures, uint16_t material);

/// The textures of a mesh to write, with the names of their image files.
struct ImageFiles {
  TextureSet set;  ///< textures named after their image files; a texture without a file keeps its own name
  std::vector<bool> has_alpha;  ///< true if the image has alpha; indexed by texture, false beyond the end
  std::vector<std::filesystem::path> written = {};  ///< paths of the image files
};

/// Returns true if the image of a material has alpha.
inline bool cutsOut(const ImageFiles& images, size_t material) {
  return material < images.has_alpha.size() && images.has_alpha[material];
}

}  // namespace lode
