#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <glm/glm.hpp>

#include "server/ingest/mesh/node_mesh.h"

namespace lode::ingest {

/// Calls visit(lower, upper, uses) for each edge of a mesh. `lower` is the smaller and `upper` the larger
/// index of the edge's two positions; `uses` is the number of triangles that have the edge. Visits edges by
/// ascending `lower`; the order of edges with equal `lower` is unspecified.
template <typename Visit>
void forEachEdge(const NodeMesh& mesh, Visit&& visit) {
  const auto forEachSide = [&mesh](auto&& visit_side) {
    for (const glm::u32vec3& t : mesh.triangles) {
      const uint32_t a = mesh.wedge_position[t.x], b = mesh.wedge_position[t.y], c = mesh.wedge_position[t.z];
      visit_side(std::min(a, b), std::max(a, b));
      visit_side(std::min(b, c), std::max(b, c));
      visit_side(std::min(c, a), std::max(c, a));
    }
  };
  // `uppers` contains the `upper` of each triangle's edges, grouped by `lower`; `begin` contains the first
  // index of each group.
  std::vector<uint32_t> begin(mesh.positions.size() + 1), uppers(3 * mesh.triangles.size());
  forEachSide([&](uint32_t lower, uint32_t) { ++begin[lower]; });
  uint32_t end = 0;
  for (uint32_t& first : begin) first = end += first;
  forEachSide([&](uint32_t lower, uint32_t upper) { uppers[--begin[lower]] = upper; });
  // Number of triangles of each edge with the current `lower`, indexed by `upper`.
  std::vector<uint32_t> uses(mesh.positions.size());
  for (uint32_t lower = 0; lower < mesh.positions.size(); ++lower) {
    const auto ends = std::span(uppers).subspan(begin[lower], begin[lower + 1] - begin[lower]);
    for (const uint32_t upper : ends) ++uses[upper];
    for (const uint32_t upper : ends)
      if (const uint32_t count = std::exchange(uses[upper], 0)) visit(lower, upper, count);
  }
}

/// Orders edges by their first end, then by their second end.
inline bool isBefore(glm::u32vec2 e, glm::u32vec2 f) noexcept { return e.x != f.x ? e.x < f.x : e.y < f.y; }

/// Returns the edges with an odd number of triangles, sorted.
std::vector<glm::u32vec2> openEdges(const NodeMesh& mesh);

/// Returns the ends of all edges with one triangle or more than two, sorted. Such edges lie on the border to
/// another leaf or on a boundary, or are non-manifold.
std::vector<uint32_t> findBorder(const NodeMesh& mesh);

}  // namespace lode::ingest
