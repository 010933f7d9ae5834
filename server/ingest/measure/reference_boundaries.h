#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "server/ingest/mesh/simplified_mesh.h"

namespace lode::ingest {

class LodInput;

/// A boundary of the original that travels up the tree, for boundaries to be measured against.
struct ReferenceBoundary {
  PositionCode from, to;
  glm::u32vec2 near;  ///< what has become of its ends in the mesh at hand: positions, or kVanished
};

/// What the boundaries of a mesh are measured against. One that is the image of none of these stands for
/// itself.
struct ReferenceBoundaries {
  std::vector<ReferenceBoundary> boundaries;
  float gap_steps =
      0;  ///< what none of all these is farther from a boundary of the original, in lattice steps
};

/// What has become of both ends of a boundary.
glm::u32vec2 imageOf(glm::u32vec2 ends, std::span<const uint32_t> became) noexcept;

/// What the boundaries of an LOD are measured against where it takes its input's place: what the input's are,
/// but for what has vanished; or the LOD's own boundaries, if that is more than `most`.
/// @param boundary_gap_steps  the LOD's, see boundaryGap()
ReferenceBoundaries referencesIn(const LodInput& input, std::span<const uint32_t> became,
                                 float boundary_gap_steps, size_t most);

}  // namespace lode::ingest
