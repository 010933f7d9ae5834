#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "server/sample/gyroid_grid.h"

namespace lode::ingest {

/// What cells of one kind hold. A kind says for each axis whether the cell is the first, one of the middle,
/// or the last.
struct GyroidCell {
  struct Vertex {
    glm::vec3 position;  ///< in periods from the cell's corner
    glm::vec3 normal;    ///< unit length, out of the solid
    float wall;          ///< periods to the block's nearest wall, at most 1
  };
  std::vector<Vertex> vertices;
  std::vector<uint16_t> number_of_edge;  ///< which vertex lies on an edge of the grid
  std::vector<GyroidGrid::Triangle> triangles;
};

using GyroidCells = std::array<GyroidCell, GyroidGrid::kCells>;

/// Meshes every kind of cell, with vertices on the surface and triangles evenly shaped.
GyroidCells makeGyroidCells(const GyroidGrid& grid);

}  // namespace lode::ingest
