#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "common/codec/texture_set.h"
#include "common/mesh.h"

namespace lode {

/// Triangles of a mesh that wear one material, in the mesh's order.
struct MaterialGroup {
  uint16_t material = 0;
  std::vector<uint32_t> triangles;
};

/// All triangles by material, least material first; one group of material 0 where the mesh names none.
std::vector<MaterialGroup> groupByMaterial(const Mesh& mesh);

/// The name of the image that a material wears on a mesh; empty if there is none.
std::string imageOf(const Mesh& mesh, const TextureSet& textures, uint16_t material);

/// The textures of a mesh that is written, with the names of the image files beside it.
struct ImageFiles {
  TextureSet set;               ///< a texture without a file keeps its own name
  std::vector<bool> has_alpha;  ///< of a texture's image; those beyond the end have none
};

/// Whether the image of a material has alpha.
inline bool cutsOut(const ImageFiles& images, size_t material) {
  return material < images.has_alpha.size() && images.has_alpha[material];
}

}  // namespace lode
