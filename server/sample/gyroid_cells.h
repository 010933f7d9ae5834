#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include <glm/glm.hpp>

namespace lode::ingest {

/// A solid gyroid, cut to a block of 3 x 3 x 3 periods with rounded edges. The gyroid function is sampled on
/// a grid of m steps per period. The surface is closed and manifold at any resolution. Source: marching
/// tetrahedra on Kuhn's subdivision of cubes.
///
/// A cell is one period. Only the outermost cells touch the walls of the block, and cells that touch the same
/// walls are equal. Therefore these 27 cells can be assembled into a block of any size with at least 2 cells
/// per axis.
class GyroidGrid {
 public:
  static constexpr int kCells = 27;

  /// The point where the surface crosses a grid edge, stored relative to a cell. The start of the edge lies
  /// in this cell, or one cell farther along x, y or z. The edge has one of 7 directions.
  struct Crossing {
    uint8_t neighbour = 0;  ///< bits 0, 1 and 2 are set if the edge starts one cell farther along x, y and z
    /// 7 * (index of the start point in its cell) + direction - 1; a direction has one bit per axis.
    uint32_t edge = 0;
  };
  using Triangle = std::array<Crossing, 3>;

  /// @param steps  steps per period, at least 4.
  explicit GyroidGrid(int steps);

  int steps() const noexcept { return m_; }
  uint32_t edgesOfCell() const noexcept { return 7u * static_cast<uint32_t>(m_ * m_ * m_); }

  /// Returns the triangles of cell x + 3 y + 9 z, counter-clockwise seen from outside the solid.
  std::vector<Triangle> triangles(int cell) const;

  /// Returns true if the surface crosses an edge of a cell.
  bool crosses(int cell, uint32_t edge) const;
  /// Returns both ends of a cell's edge, in steps from the block's corner.
  std::pair<glm::ivec3, glm::ivec3> ends(int cell, uint32_t edge) const;
  /// Returns the minimum corner of a cell, in steps from the block's corner.
  glm::ivec3 origin(int cell) const { return m_ * glm::ivec3(cell % 3, cell / 3 % 3, cell / 9); }

  /// Returns the approximate depth below the surface (x), which is negative outside, and the gradient of the
  /// depth (y, z, w). @param at  point in steps from the block's corner; the depth is in steps too.
  glm::dvec4 depth(const glm::dvec3& at) const;

 private:
  bool inside(const glm::ivec3& point) const {
    const int n = 3 * m_ + 1;
    return inside_[static_cast<size_t>((point.z * n + point.y) * n + point.x)];
  }
  Crossing crossing(const glm::ivec3& cube, int from, int to) const;
  void addOfTetrahedron(const glm::ivec3& cube, const std::array<int, 4>& corners, unsigned signs,
                        std::vector<Triangle>& to) const;

  int m_;
  std::vector<bool> inside_;
};

/// The mesh that all cells of one kind share. The kind tells whether a cell is first, inner or last along
/// each axis.
struct GyroidCell {
  struct Vertex {
    glm::vec3 position;  ///< position in periods from the cell's minimum corner
    glm::vec3 normal;    ///< unit normal that points out of the solid
    float wall;          ///< distance from the block's nearest wall, in periods; at most 1
  };
  std::vector<Vertex> vertices;
  std::vector<uint16_t> number_of_edge;  ///< index of the vertex on each grid edge that the surface crosses
  std::vector<GyroidGrid::Triangle> triangles;
};

using GyroidCells = std::array<GyroidCell, GyroidGrid::kCells>;

/// Creates the meshes of all kinds of cells, with vertices on the surface and evenly shaped triangles.
GyroidCells makeGyroidCells(const GyroidGrid& grid);

}  // namespace lode::ingest
