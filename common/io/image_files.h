#pragma once

#include <cstddef>
#include <vector>

#include "common/codec/texture_set.h"

namespace lode {

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
