#include "server/sample/gyroid_cells.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace lode::ingest {
namespace {

// Value of the gyroid function at the surface. With this value, slightly less than half of the block is
// solid.
constexpr double kLevel = -0.2;
constexpr double kSteepness = 1.25;  // approximate slope of the function at the surface, per radian
constexpr double kWall = 0.5;        // distance of the block's walls from the grid's border, in steps
// Phase of the gyroid at the walls. At this phase the walls do not cut off separate pieces.
constexpr double kPhase = std::numbers::pi / 4;

/// Six tetrahedra around the diagonal of a cube, as corner indices, positively oriented.
constexpr std::array<std::array<int, 4>, 6> kTetrahedra{
    {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}}};

glm::ivec3 bits(int number) { return {number & 1, number >> 1 & 1, number >> 2}; }

/// Returns the minimum of two depths with gradients, smoothed if the depths differ by less than `radius`.
glm::dvec4 smoothMin(const glm::dvec4& a, const glm::dvec4& b, double radius) {
  const double gap = radius - std::abs(a.x - b.x);
  const glm::dvec4& smaller = a.x < b.x ? a : b;
  if (gap <= 0) return smaller;
  const glm::dvec4& larger = a.x < b.x ? b : a;
  glm::dvec4 result = glm::mix(smaller, larger, gap / (2 * radius));
  result.x = smaller.x - gap * gap / (4 * radius);
  return result;
}

constexpr int kRelaxations = 6;
constexpr double kRelaxation = 0.6;

/// The vertices of all 27 cells, in cell order.
struct Block {
  std::array<size_t, GyroidGrid::kCells> first{};
  std::vector<glm::dvec3> positions;                 ///< positions in steps from the block's corner
  std::vector<std::pair<uint32_t, uint32_t>> edges;  ///< mesh edges, in both directions
};

int neighbourOf(int cell, uint8_t neighbour) {
  return cell + (neighbour & 1) + 3 * (neighbour >> 1 & 1) + 9 * (neighbour >> 2);
}

/// Adds a cell's vertices: one on each grid edge that the surface crosses, at the interpolated crossing.
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

/// Moves every vertex along the surface towards the mean of its neighbours.
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

GyroidGrid::GyroidGrid(int steps) : m_(steps) {
  const int n = 3 * m_ + 1;
  inside_.reserve(static_cast<size_t>(n) * n * n);
  for (int z = 0; z < n; ++z) {
    for (int y = 0; y < n; ++y) {
      for (int x = 0; x < n; ++x) inside_.push_back(depth({x, y, z}).x > 0);
    }
  }
}

glm::dvec4 GyroidGrid::depth(const glm::dvec3& at) const {
  const double radians = 2 * std::numbers::pi / m_;
  // Reduce the point to one period first, so that points a whole number of periods apart give exactly the
  // same value.
  const glm::dvec3 phase =
      radians * (at - static_cast<double>(m_) * glm::floor(at / static_cast<double>(m_)));
  const glm::dvec3 s = glm::sin(phase + kPhase), c = glm::cos(phase + kPhase);
  const double value = s.x * c.y + s.y * c.z + s.z * c.x;
  const glm::dvec3 gradient(c.x * c.y - s.z * s.x, c.y * c.z - s.x * s.y, c.z * c.x - s.y * s.z);
  const double scale = 1 / (radians * kSteepness);
  glm::dvec4 depth((kLevel - value) * scale, gradient * (-1 / kSteepness));
  const double radius = 0.1 * m_ + 0.5;
  for (int axis = 0; axis < 3; ++axis) {
    glm::dvec4 low(at[axis] - kWall, 0, 0, 0), high(3 * m_ - kWall - at[axis], 0, 0, 0);
    low[axis + 1] = 1;
    high[axis + 1] = -1;
    depth = smoothMin(smoothMin(depth, low, radius), high, radius);
  }
  return depth;
}

bool GyroidGrid::crosses(int cell, uint32_t edge) const {
  const auto [from, to] = ends(cell, edge);
  const int last = 3 * m_;
  return to.x <= last && to.y <= last && to.z <= last && inside(from) != inside(to);
}

std::pair<glm::ivec3, glm::ivec3> GyroidGrid::ends(int cell, uint32_t edge) const {
  const int point = static_cast<int>(edge / 7), direction = static_cast<int>(edge % 7) + 1;
  const glm::ivec3 from = origin(cell) + glm::ivec3(point % m_, point / m_ % m_, point / (m_ * m_));
  return {from, from + bits(direction)};
}

/// Returns the crossing on an edge between two corners of a tetrahedron. The edge starts at the corner that
/// is not larger than the other on any axis; such a corner always exists.
GyroidGrid::Crossing GyroidGrid::crossing(const glm::ivec3& cube, int from, int to) const {
  const glm::ivec3 base = cube + bits(from & to);
  Crossing result;
  glm::ivec3 local = base;
  for (int axis = 0; axis < 3; ++axis) {
    if (local[axis] < m_) continue;
    local[axis] -= m_;
    result.neighbour |= static_cast<uint8_t>(1 << axis);
  }
  const int direction = from ^ to;
  result.edge = static_cast<uint32_t>(7 * ((local.z * m_ + local.y) * m_ + local.x) + direction - 1);
  return result;
}

void GyroidGrid::addOfTetrahedron(const glm::ivec3& cube, const std::array<int, 4>& corners, unsigned signs,
                                  std::vector<Triangle>& to) const {
  std::array<int, 4> in{}, out{};
  size_t ins = 0, outs = 0;
  bool turned = false;  // true if sorting the inside corners first reverses the orientation
  for (const int corner : corners) {
    if ((signs >> corner & 1) != 0) {
      in[ins++] = corner;
      turned ^= outs % 2 != 0;
    } else {
      out[outs++] = corner;
    }
  }
  if (ins == 0 || outs == 0) return;
  const auto between = [&](int a, int b) { return crossing(cube, in[a], out[b]); };
  std::array<Crossing, 4> loop;
  size_t size = 3;
  if (ins == 1) {
    loop = {between(0, 0), between(0, 1), between(0, 2)};
  } else if (ins == 3) {
    loop = {between(0, 0), between(1, 0), between(2, 0)};
  } else {
    loop = {between(0, 0), between(0, 1), between(1, 1), between(1, 0)};
    size = 4;
  }
  if (turned) std::reverse(loop.begin(), loop.begin() + static_cast<ptrdiff_t>(size));
  for (size_t i = 2; i < size; ++i) to.push_back({loop[0], loop[i - 1], loop[i]});
}

std::vector<GyroidGrid::Triangle> GyroidGrid::triangles(int cell) const {
  std::vector<Triangle> result;
  for (int i = 0; i < m_ * m_ * m_; ++i) {
    const glm::ivec3 cube(i % m_, i / m_ % m_, i / (m_ * m_));
    unsigned signs = 0;
    for (int k = 0; k < 8; ++k) signs |= (inside(origin(cell) + cube + bits(k)) ? 1u : 0u) << k;
    if (signs == 0 || signs == 255) continue;
    for (const std::array<int, 4>& corners : kTetrahedra) addOfTetrahedron(cube, corners, signs, result);
  }
  return result;
}

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
