#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "server/ingest/measure/point_triangle.h"
#include "server/ingest/mesh/node_mesh.h"

namespace lode::ingest {

/// Distance from points to a mesh, in lattice steps, by a tree of boxes around its triangles, halved by
/// number along the longest side of their middles. Empty space around a point costs nothing, unlike in a
/// grid's cells. Const functions are thread safe.
class TriangleTree {
 public:
  explicit TriangleTree(const NodeMesh& mesh);

  static constexpr float kInfinity = std::numeric_limits<float>::infinity();
  struct Nearest {
    float squared;   ///< of the distance
    float distance;  ///< infinity if the mesh has no triangles
    uint32_t triangle;
  };
  static constexpr Nearest kNothing{kInfinity, kInfinity, 0};

  /// @param enough  the search ends at a triangle that is as near as this, which need not be the nearest.
  /// @param known   what is returned if no triangle is nearer: the nearer it is, the shorter is the search.
  Nearest nearest(glm::vec3 point, float enough = 0, Nearest known = kNothing) const noexcept;
  float distance(glm::vec3 point) const noexcept { return nearest(point).distance; }
  /// From one of the mesh's triangles.
  float squaredDistance(glm::vec3 point, uint32_t triangle) const noexcept {
    return triangles_[place_[triangle]].squaredDistance(point);
  }

 private:
  struct Triangle {
    glm::vec3 a;
    TriangleSides sides;

    float squaredDistance(glm::vec3 point) const noexcept {
      return squaredDistanceToTriangle(point - a, sides);
    }
  };
  /// A box; the first of its halves is the next one.
  struct Box {
    glm::vec3 min, max;
    uint32_t second = 0;          ///< half
    uint32_t begin = 0, end = 0;  ///< of its triangles, if it is not halved

    float squaredDistance(glm::vec3 point) const noexcept {
      const glm::vec3 outside = glm::max(glm::max(min - point, point - max), 0.f);
      return glm::dot(outside, outside);
    }
  };
  struct Middle {
    glm::vec3 at;
    uint32_t triangle;
  };
  uint32_t build(std::span<const Triangle> triangles, std::span<Middle> middles);

  std::vector<Box> boxes_;
  std::vector<Triangle> triangles_;  ///< as their boxes come
  std::vector<uint32_t> number_;     ///< of each of those in the mesh
  std::vector<uint32_t> place_;      ///< of each of the mesh's in triangles_
};

}  // namespace lode::ingest
