#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include <glm/glm.hpp>

#include "server/ingest/measure/point_triangle.h"
#include "server/ingest/mesh/node_mesh.h"

namespace lode::ingest {

/// Distance from points to a mesh, in lattice steps, by a uniform grid: shells of cells until what has
/// been found is nearer than the next. Const functions are thread safe.
class TriangleGrid {
 public:
  static constexpr float kInfinity = std::numeric_limits<float>::infinity();

  explicit TriangleGrid(const NodeMesh& mesh);

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
  float distance(PositionCode point) const noexcept { return distance(glm::vec3(unpackPosition(point))); }
  /// From one of the mesh's triangles.
  float squaredDistance(glm::vec3 point, uint32_t number) const noexcept {
    const Triangle& triangle = triangles_[number];
    return squaredDistanceToTriangle(point - triangle.a, triangle.sides);
  }
  /// Entries of triangles in cells: what the grid's memory goes with.
  size_t memberCount() const noexcept { return members_.size(); }

 private:
  struct Triangle {
    glm::vec3 a;
    TriangleSides sides;
  };
  /// The cells that a triangle's box touches, both ends inside.
  struct Cover {
    glm::ivec3 low, high;
  };
  void chooseCells(glm::vec3 min, glm::vec3 size);
  void fillCells();
  Cover coverOf(const Triangle& triangle) const noexcept;
  glm::ivec3 cellOf(glm::vec3 point) const noexcept;
  size_t indexOf(glm::ivec3 cell) const noexcept {
    return static_cast<size_t>((cell.z * dims_.y + cell.y) * dims_.x + cell.x);
  }
  float roomIn(glm::vec3 point, glm::ivec3 centre, int radius) const noexcept;
  void searchShell(glm::vec3 point, glm::ivec3 centre, int radius, float enough,
                   Nearest& best) const noexcept;
  void searchCell(glm::vec3 point, glm::ivec3 cell, float enough, Nearest& best) const noexcept;

  std::vector<Triangle> triangles_;
  std::vector<glm::vec4>
      spheres_;  ///< around each triangle, centre and radius: most are too far away to look closer
  glm::vec3 min_{0};
  float cell_ = 1;
  float cells_per_step_ = 1;
  glm::ivec3 dims_{1};
  std::vector<uint32_t> begin_;    ///< of each cell in members_, and the end
  std::vector<uint32_t> members_;  ///< triangles whose box touches the cell
};

}  // namespace lode::ingest
