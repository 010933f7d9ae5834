#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "server/ingest/simplify/collapse_mesh.h"
#include "server/ingest/simplify/edge_surroundings.h"

namespace lode::ingest {

/// Points of the original mesh that simplification has moved away from. Each merged position keeps up to four
/// points that are farthest from the triangles around the position. Quadrics alone do not notice when a
/// surface becomes shorter, because they measure distances to infinite planes: the tip of a needle is close
/// to the planes of its sides even after the needle is cut short.
class FarPoints {
 public:
  explicit FarPoints(const CollapseMesh& mesh) : mesh_(mesh), kept_(mesh.positions.size()) {}

  /// Prefetches the points kept for both ends of an edge.
  void prefetch(uint32_t u, uint32_t v) const noexcept {
    for (const uint32_t end : {u, v}) {
      const char* const kept = reinterpret_cast<const char*>(&kept_[end]);
      __builtin_prefetch(kept);
      __builtin_prefetch(kept + sizeof(Kept) - 1);
    }
  }
  /// Measures the distances to the triangles that remain if an edge collapses to `to`. Measures from the
  /// points kept for both ends, and from the ends themselves if they are original vertices.
  /// @return the largest squared distance in square lattice steps; 0 if there are no points.
  float measure(const EdgeSurroundings& around, glm::dvec3 to);
  /// Keeps the farthest points of the edge that was measured last. Call after this edge has collapsed into
  /// `position`.
  void join(uint32_t position);

 private:
  static constexpr uint32_t kMostKept = 4;

  struct Point {
    glm::vec3 at;
    float squared;  ///< squared distance to the nearest triangle
    /// Smallest squared distance so far in each SIMD lane; used by measure() only.
    Four least;
  };
  struct Kept {
    std::array<glm::vec3, kMostKept> points;
    uint32_t count = 0;
  };

  void gatherPoints(uint32_t position, glm::dvec3 to);

  const CollapseMesh& mesh_;
  std::vector<Kept> kept_;
  std::vector<Point> points_;  ///< points of the edge measured last
};

}  // namespace lode::ingest
