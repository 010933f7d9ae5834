#pragma once

#include <vector>

#include <glm/glm.hpp>

#include "server/ingest/preview/cluster_grid.h"
#include "server/ingest/soup/face_batch.h"
#include "server/ingest/soup/packed_input.h"
#include "server/ingest/soup/triangulate.h"

namespace lode::ingest {

/// Place of a triangle in a block of faces.
struct TrianglePlace {
  size_t face;           ///< index of the face
  glm::u64vec3 corners;  ///< indices of the corners
};

/// Calls visit(vertices, place) for each triangle of a block, with polygons cut as in the build.
template <typename Visit>
void forEachTriangle(const PackedInput::FaceBlock& block, const ClusterGrid& grid, Visit&& visit) {
  std::vector<glm::dvec3> outline;
  std::vector<glm::u32vec3> cut;
  size_t number = 0;
  forEachFace(block, [&](size_t first, uint32_t corners) {
    const uint32_t* const vertices = &block.corners[first];
    const size_t face = number++;
    const auto visitCorners = [&](glm::u32vec3 t) {
      visit(glm::u32vec3(vertices[t.x], vertices[t.y], vertices[t.z]),
            TrianglePlace{face, glm::u64vec3(first) + glm::u64vec3(t)});
    };
    if (corners == 3) return visitCorners({0, 1, 2});
    outline.clear();
    for (uint32_t c = 0; c < corners; ++c) outline.emplace_back(grid.positionOf(vertices[c]));
    triangulate(outline, cut);
    for (const glm::u32vec3& t : cut) visitCorners(t);
  });
}

}  // namespace lode::ingest
