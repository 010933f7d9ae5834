#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

#include <glm/glm.hpp>

#include "common/node_key.h"
#include "server/ingest/mesh/soup_triangle.h"

namespace lode::ingest {

/// Spreads the lowest 21 bits of `x`: inserts two zero bits above each.
constexpr uint64_t spreadBits(uint64_t x) noexcept {
  x = (x | x << 32) & 0x001f00000000ffffULL;
  x = (x | x << 16) & 0x001f0000ff0000ffULL;
  x = (x | x << 8) & 0x100f00f00f00f00fULL;
  x = (x | x << 4) & 0x10c30c30c30c30c3ULL;
  return (x | x << 2) & 0x1249249249249249ULL;
}

/// Assigns triangles to octree cells. The root cell is a cube with its minimum at lattice point 0 and a side
/// as long as the model's longest extent, so that the first split divides the model for any lattice step. A
/// triangle's code is the Morton code of the depth-20 cell that contains the triangle's centroid, computed in
/// integers.
class CellGrid {
 public:
  explicit CellGrid(glm::uvec3 extent) noexcept
      : side_thirds_(3 * (static_cast<uint64_t>(std::max({extent.x, extent.y, extent.z})) + 1)) {}

  uint64_t code(const SoupTriangle& triangle) const noexcept {
    const glm::uvec3 sum = unpackPosition(triangle.corners[0]) + unpackPosition(triangle.corners[1]) +
                           unpackPosition(triangle.corners[2]);
    return spreadBits(cell(sum.x)) | spreadBits(cell(sum.y)) << 1 | spreadBits(cell(sum.z)) << 2;
  }

 private:
  uint64_t cell(uint64_t sum) const noexcept { return (sum << kMaxDepth) / side_thirds_; }
  uint64_t side_thirds_;
};

/// Returns the node at `depth` that contains the cell with the given code.
constexpr NodeKey cellAt(uint64_t code, int depth) noexcept {
  return {uint64_t{1} << 3 * depth | code >> 3 * (kMaxDepth - depth)};
}

/// Returns the depth of the deepest node that contains the cells with both codes.
constexpr int commonDepth(uint64_t a, uint64_t b) noexcept {
  return a == b ? kMaxDepth : kMaxDepth - (static_cast<int>(std::bit_width(a ^ b)) + 2) / 3;
}

}  // namespace lode::ingest
