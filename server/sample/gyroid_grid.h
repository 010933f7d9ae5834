#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include <glm/glm.hpp>

namespace lode::ingest {

/// The solid of the gyroid, cut to a block of 3 x 3 x 3 periods with rounded edges and sampled on a grid of m
/// steps a period. Triangles of its surface lie in the tetrahedra that the grid's cubes fall into, so that it
/// is closed and manifold whatever the sampling. Source: marching tetrahedra on Kuhn's subdivision.
///
/// A period is a cell. Since the block's walls reach only into the outermost cells, and all others are alike,
/// a block of any number of cells >= 2 an axis can be put together from the 27 of this one.
class GyroidGrid {
 public:
  static constexpr int kCells = 27;

  /// Where the surface crosses an edge of the grid, seen from a cell: the edge leaves a point of that cell,
  /// or of one of the neighbours above it, in one of 7 directions.
  struct Crossing {
    uint8_t neighbour = 0;  ///< bits 0, 1, 2: the next cell along x, y, z
    uint32_t edge = 0;      ///< 7 x point of that cell + direction - 1; bits of a direction as above
  };
  using Triangle = std::array<Crossing, 3>;

  /// @param steps  a period, at least 4.
  explicit GyroidGrid(int steps);

  int steps() const noexcept { return m_; }
  uint32_t edgesOfCell() const noexcept { return 7u * static_cast<uint32_t>(m_ * m_ * m_); }

  /// Triangles of cell x + 3 y + 9 z, counter-clockwise seen from outside the solid.
  std::vector<Triangle> triangles(int cell) const;

  /// Whether the surface crosses an edge of a cell.
  bool crosses(int cell, uint32_t edge) const;
  /// Ends of an edge of a cell, in steps from the block's corner.
  std::pair<glm::ivec3, glm::ivec3> ends(int cell, uint32_t edge) const;
  /// The corner of a cell, in steps from the block's corner.
  glm::ivec3 origin(int cell) const { return m_ * glm::ivec3(cell % 3, cell / 3 % 3, cell / 9); }

  /// Depth below the surface (x), about in steps and negative outside, and its gradient (y, z, w), at a point
  /// in steps from the block's corner.
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

}  // namespace lode::ingest
