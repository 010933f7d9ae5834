#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "server/ingest/measure/triangle_tree.h"
#include "server/ingest/mesh/node_mesh.h"
#include "server/ingest/mesh/segment_distance.h"

namespace lode::ingest {

/// Triangles of a surface of which each has an edge in common with the next.
struct TriangleChain {
  static constexpr size_t kMostEdges = 6;

  FourSegments eachTwice(size_t edge, size_t other) const noexcept {
    return {FourVectors(from[edge], from[edge], from[other], from[other]),
            FourVectors(to[edge], to[edge], to[other], to[other])};
  }

  std::array<uint32_t, kMostEdges + 1> triangles;
  std::array<Four, kMostEdges> from, to;  ///< ends of the edges between a triangle and the next
  size_t edge_count = 0;
};

/// Distance from points to a mesh, in lattice steps, by walking over it: from the triangles around a position
/// to those around the next, as long as they come nearer. Never below the true distance; above it where the
/// mesh, as seen from the start, first leads away from the nearest place or where that is on another piece.
/// Many times faster than TriangleTree where a position near the point is known. Const functions are thread
/// safe.
class SurfaceWalk {
 public:
  /// @param mesh  its positions' numbers are what walks start at.
  explicit SurfaceWalk(const NodeMesh& mesh);

  /// @param point  lattice steps, like all here
  /// @param start  a position of the mesh that a triangle has; infinity if none has.
  /// @param enough  the walk ends where it is as near as this.
  float distance(glm::vec3 point, uint32_t start, float enough) const noexcept;
  /// The same; `start` becomes a position where the walk has ended, from which that of a point nearby is
  /// shorter.
  float distanceOnwards(glm::vec3 point, uint32_t& start, float enough) const noexcept;
  /// From one of the mesh's triangles.
  float squaredDistance(glm::vec3 point, uint32_t triangle) const noexcept {
    return triangles_[triangle].squaredDistance(point);
  }
  const PackedTriangle& triangle(uint32_t number) const noexcept { return triangles_[number]; }
  /// From a triangle onwards; `triangle` becomes the one where the walk has ended.
  float distanceFrom(glm::vec3 point, uint32_t& triangle, float enough) const noexcept;
  /// A place on the mesh near a point.
  struct Place {
    uint32_t triangle = 0;  ///< of the mesh
    glm::vec3 shares{0};    ///< of its corners; they add up to 1
    float distance = 0;     ///< of the point; like that of distance()
  };
  /// Where a walk ends, or before it a triangle around the start that the point lies above.
  /// @param start  a position of the mesh that a triangle has.
  Place placeOf(glm::vec3 point, uint32_t start) const noexcept;
  /// Of a position that a triangle has.
  Place placeAt(uint32_t position) const noexcept;
  /// The triangles below a segment, from one that its first end is beside to one that its last end is, or
  /// another that this lies above and is near to.
  /// @return false where there is no such chain, or it is not found at once.
  bool chainAlong(const Segment& segment, uint32_t first, uint32_t last, float near_squared,
                  TriangleChain& chain) const noexcept;
  /// By a look at every triangle. @param known  what is returned if none is nearer.
  TriangleTree::Nearest nearestOfAll(glm::vec3 point, TriangleTree::Nearest known) const noexcept;

 private:
  struct Nearest {
    float squared;
    uint32_t triangle;
  };
  Nearest walk(glm::vec3 point, uint32_t start, float enough_squared) const noexcept;
  std::optional<Place> placeAround(glm::vec3 point, uint32_t position) const noexcept;
  void lookAt(glm::vec3 point, uint32_t triangle, Nearest& best) const noexcept;
  /// Four of those around a position; where it has no more, the last again.
  FourTriangles trianglesFrom(uint32_t begin, uint32_t end) const noexcept {
    const auto at = [&](uint32_t i) -> const PackedTriangle& {
      return triangles_[around_[std::min(begin + i, end - 1)]];
    };
    return {at(0), at(1), at(2), at(3)};
  }
  /// Another triangle that has both positions; the given one if there is none.
  uint32_t beyond(uint32_t triangle, uint32_t from, uint32_t to) const noexcept;
  bool isAbove(glm::vec3 point, uint32_t triangle) const noexcept;
  void lookAbove(glm::vec3 point, uint32_t position, float enough_squared, Nearest& best) const noexcept;
  void lookAround(glm::vec3 point, uint32_t position, float enough_squared, Nearest& best) const noexcept;

  float longest_edge_ = 0;
  std::vector<PackedTriangle> triangles_;
  std::vector<glm::u32vec3> corners_;     ///< positions, of each triangle
  std::vector<uint32_t> begin_, around_;  ///< triangles around each position
};

}  // namespace lode::ingest
