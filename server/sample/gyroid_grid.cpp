#include "server/sample/gyroid_grid.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace lode::ingest {
namespace {

constexpr double kLevel = -0.2;                  // of the gyroid's function; somewhat less than half is solid
constexpr double kSteepness = 1.25;              // about the function's slope at the surface, in radians
constexpr double kWall = 0.5;                    // steps from the border of the grid to the block's wall
constexpr double kPhase = std::numbers::pi / 4;  // where the walls cut: no crumb is cut off

/// The six tetrahedra around the diagonal of a cube, by its corners, positively oriented.
constexpr std::array<std::array<int, 4>, 6> kTetrahedra{
    {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}}};

glm::ivec3 bits(int number) { return {number & 1, number >> 1 & 1, number >> 2}; }

/// The smaller of two depths, rounded where they differ by less than `radius`. Both hold their gradients.
glm::dvec4 smoothMin(const glm::dvec4& a, const glm::dvec4& b, double radius) {
  const double gap = radius - std::abs(a.x - b.x);
  const glm::dvec4& smaller = a.x < b.x ? a : b;
  if (gap <= 0) return smaller;
  const glm::dvec4& larger = a.x < b.x ? b : a;
  glm::dvec4 result = glm::mix(smaller, larger, gap / (2 * radius));
  result.x = smaller.x - gap * gap / (4 * radius);
  return result;
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
  // Points that differ by whole periods are to have the same bits.
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

/// On the edge between two corners of a cube. In these tetrahedra one of two corners is always above the
/// other on each axis or level with it.
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
  bool turned = false;  // whether sorting those inside before those outside changes the orientation
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

}  // namespace lode::ingest
