#pragma once

#include "common/codec/texture_set.h"
#include "common/mesh.h"

namespace lode {

/// The true texture coordinates of a vertex, v = 0 at the image's bottom.
inline glm::dvec2 trueTextureCoordinates(const TextureSet& set, const VertexAttributes& vertex) {
  return set.uv_origin + glm::dvec2(vertex.texture) * uvStep(set);
}

}  // namespace lode
