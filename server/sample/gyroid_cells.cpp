#include "server/sample/gyroid_cells.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace lode::ingest {
namespace {

constexpr int kRelaxations = 6;
constexpr double kRelaxation = 0.6;

/// The vertices of all 27 cells, one cell after the other, in steps from the block's corner.
struct Block {
  std::array<size_t, GyroidGrid::kCells> first{};
  std::vector<glm::dvec3> positions;
  std::vector<std::pair<uint32_t, uint32_t>> edges;  ///< of the mesh, in both directions
};

int neighbourOf(int cell, uint8_t neighbour) {
  return cell + (neighbour & 1) + 3 * (neighbour >> 1 & 1) + 9 * (neighbour >> 2);
}

/// Numbers a cell's vertices, and puts each between the ends of its edge.
void addVertices(const GyroidGrid& grid, int cell, GyroidCell& to, Block& block) {
  block.first[cell] = block.positions.size();
  to.number_of_edge.resize(grid.edgesOfCell());
  for (uint32_t edge = 0; edge < grid.edgesOfCell(); ++edge) {
    if (!grid.crosses(cell, edge)) continue;
    const auto [from, end] = grid.ends(cell, edge);
    const double a = grid.depth(from).x, b = grid.depth(end).x;
    to.number_of_edge[edge] = static_cast<uint16_t>(to.vertices.size());
    to.vertices.emplace_back();
    block.positions.push_back(glm::mix(glm::dvec3(from), glm::dvec3(end), std::clamp(a / (a - b), 0.1, 0.9)));
  }
}

void addEdges(const GyroidCells& cells, int cell, Block& block) {
  for (const GyroidGrid::Triangle& triangle : cells[cell].triangles) {
    std::array<uint32_t, 3> corners{};
    for (size_t i = 0; i < 3; ++i) {
      const int of = neighbourOf(cell, triangle[i].neighbour);
      corners[i] = static_cast<uint32_t>(block.first[of] + cells[of].number_of_edge[triangle[i].edge]);
    }
    for (size_t i = 0; i < 3; ++i) block.edges.emplace_back(corners[i], corners[(i + 1) % 3]);
  }
}

glm::dvec3 onSurface(const GyroidGrid& grid, const glm::dvec3& at) {
  const glm::dvec4 depth = grid.depth(at);
  const glm::dvec3 gradient(depth.y, depth.z, depth.w);
  return at - gradient * std::clamp(depth.x / std::max(glm::dot(gradient, gradient), 0.1), -0.5, 0.5);
}

/// Moves every vertex towards the middle of its neighbours, along the surface.
void relax(const GyroidGrid& grid, Block& block) {
  std::vector<glm::dvec3> sums(block.positions.size());
  std::vector<double> degrees(block.positions.size());
  for (const auto& [from, to] : block.edges) {
    sums[from] += block.positions[to];
    degrees[from] += 1;
  }
  for (size_t i = 0; i < block.positions.size(); ++i) {
    glm::dvec3& at = block.positions[i];
    at = onSurface(grid, onSurface(grid, glm::mix(at, sums[i] / degrees[i], kRelaxation)));
  }
}

}  // namespace

GyroidCells makeGyroidCells(const GyroidGrid& grid) {
  GyroidCells cells;
  Block block;
  for (int cell = 0; cell < GyroidGrid::kCells; ++cell) {
    addVertices(grid, cell, cells[cell], block);
    cells[cell].triangles = grid.triangles(cell);
  }
  for (int cell = 0; cell < GyroidGrid::kCells; ++cell) addEdges(cells, cell, block);
  for (int i = 0; i < kRelaxations; ++i) relax(grid, block);
  const double m = grid.steps();
  for (int cell = 0; cell < GyroidGrid::kCells; ++cell) {
    for (size_t i = 0; i < cells[cell].vertices.size(); ++i) {
      const glm::dvec3 at = block.positions[block.first[cell] + i];
      const glm::dvec4 depth = grid.depth(at);
      const glm::dvec3 wall = glm::min(at, 3 * m - at);
      cells[cell].vertices[i] = {(at - glm::dvec3(grid.origin(cell))) / m,
                                 -glm::normalize(glm::dvec3(depth.y, depth.z, depth.w)),
                                 static_cast<float>(std::min({wall.x / m, wall.y / m, wall.z / m, 1.0}))};
    }
  }
  return cells;
}

}  // namespace lode::ingest
