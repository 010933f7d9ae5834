#pragma once

#include <span>

#include <glm/glm.hpp>

#include "server/ingest/mesh/simplified_mesh.h"

namespace lode::ingest {

/// What no rim of a simplified mesh is farther from those of the mesh that it was made of, in lattice steps:
/// at most 2 % or a quarter of a step too much. A rim is the image of rims, and is compared with those alone
/// that have become it or what meets its ends.
/// @param rims  open edges of the input, by position.
float rimGap(const SimplifiedMesh& simplified, const NodeMesh& input, std::span<const glm::u32vec2> rims);

}  // namespace lode::ingest
