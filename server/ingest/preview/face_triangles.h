#pragma once

#include <vector>

#include <glm/glm.hpp>

#include "server/ingest/preview/cluster_grid.h"
#include "server/ingest/soup/face_batch.h"
#include "server/ingest/soup/packed_input.h"
#include "server/ingest/soup/triangulate.h"

namespace lode::ingest {

/// Calls visit(vertices, colour) for each triangle of a block, with polygons cut as in the build. `colour` is
/// the colour of the face, or null if faces have none.
template <typename Visit>
void forEachTriangle(const PackedInput::FaceBlock& block, const ClusterGrid& grid, Visit&& visit) {
  std::vector<glm::dvec3> outline;
  std::vector<glm::u32vec3> cut;
  size_t number = 0;
  forEachFace(block, [&](size_t first, uint32_t corners) {
    const uint32_t* const vertices = &block.corners[first];
    const glm::u8vec4* const colour = block.colours.empty() ? nullptr : &block.colours[number];
    ++number;
    if (corners == 3) return visit(glm::u32vec3(vertices[0], vertices[1], vertices[2]), colour);
    outline.clear();
    for (uint32_t c = 0; c < corners; ++c) outline.emplace_back(grid.positionOf(vertices[c]));
    triangulate(outline, cut);
    for (const glm::u32vec3& t : cut)
      visit(glm::u32vec3(vertices[t.x], vertices[t.y], vertices[t.z]), colour);
  });
}

}  // namespace lode::ingest
