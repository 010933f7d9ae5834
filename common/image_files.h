#pragma once

#include <vector>

#include "common/texture_set.h"

namespace lode {

/// The textures of a mesh that is written, with the names of the image files beside it.
struct ImageFiles {
  TextureSet set;               ///< a texture without a file keeps its own name
  std::vector<bool> has_alpha;  ///< of a texture's image; those beyond the end have none
};

}  // namespace lode
