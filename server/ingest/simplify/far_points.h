#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "server/ingest/simplify/collapse_mesh.h"
#include "server/ingest/simplify/edge_surroundings.h"

namespace lode::ingest {

/// What a mesh that is simplified has moved away from: each position that others were merged into keeps the
/// few points of the input that lie farthest from the triangles around it. A quadric says how far planes are,
/// which go on where the surface ends: the tip of a needle lies close to all of its sides' planes wherever it
/// is cut off.
class FarPoints {
 public:
  explicit FarPoints(const CollapseMesh& mesh) : mesh_(mesh), kept_(mesh.positions.size()) {}

  /// Gets ready for a look at an edge.
  void fetch(uint32_t u, uint32_t v) const noexcept {
    for (const uint32_t end : {u, v}) {
      const char* const kept = reinterpret_cast<const char*>(&kept_[end]);
      __builtin_prefetch(kept);
      __builtin_prefetch(kept + sizeof(Kept) - 1);
    }
  }
  /// @param to  where the ends of the edge would go, to become one.
  /// @return the square of the distance, in lattice steps, of the farthest known point of both from what
  /// would
  ///         lie around; 0 if that is nothing.
  float look(const EdgeSurroundings& around, glm::dvec3 to);
  /// The ends of the edge that was looked at last have become one position.
  void join(uint32_t position);

 private:
  static constexpr uint32_t kMostKept = 4;

  struct Point {
    glm::vec3 at;
    float squared;  ///< of its distance
    Four least;     ///< scratch: the same, of every fourth triangle
  };
  struct Kept {
    std::array<glm::vec3, kMostKept> points;
    uint32_t count = 0;
  };

  void gatherPoints(uint32_t position, glm::dvec3 to);

  const CollapseMesh& mesh_;
  std::vector<Kept> kept_;
  std::vector<Point> points_;  ///< of the edge that was looked at last
};

}  // namespace lode::ingest
