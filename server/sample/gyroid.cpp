#include "server/sample/gyroid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "server/sample/gyroid_cells.h"
#include "server/sample/relief.h"

namespace lode::ingest {
namespace {

constexpr int kLeastSteps = 4, kMostSteps = 24;
constexpr double kRoughness = 0.22;  // height of the relief, in periods
constexpr double kBend = 0.22, kBendFrequency = 0.8;

using CellCounts = std::array<uint64_t, GyroidGrid::kCells>;

/// Order of the cells of a block; a cell is one period of the gyroid. Vertices and triangles are numbered
/// cell by cell; x varies fastest.
class CellOrder {
 public:
  explicit CellOrder(const glm::u64vec3& cells) : cells_(cells) {}

  uint64_t cells() const { return cells_.x * cells_.y * cells_.z; }
  const glm::u64vec3& axes() const { return cells_; }
  glm::u64vec3 cell(uint64_t number) const {
    return {number % cells_.x, number / cells_.x % cells_.y, number / (cells_.x * cells_.y)};
  }
  int kindOf(const glm::u64vec3& cell) const {
    return kindAlong(0, cell.x) + 3 * kindAlong(1, cell.y) + 9 * kindAlong(2, cell.z);
  }

  /// Sums a value over all cells. @param counts  the value for each kind of cell, such as its number of
  /// vertices.
  uint64_t sum(const CellCounts& counts) const { return before({0, 0, cells_.z}, counts); }

  /// Sums a value over the cells before `cell`.
  uint64_t before(const glm::u64vec3& cell, const CellCounts& counts) const {
    uint64_t sum = 0;
    for (int z = 0; z < 3; ++z) {
      sum += countBefore(2, cell.z, z) * sumOfLayer(z, counts);
      if (cell.z == cells_.z || z != kindAlong(2, cell.z)) continue;
      for (int y = 0; y < 3; ++y) {
        sum += countBefore(1, cell.y, y) * sumOfRow(y, z, counts);
        if (y != kindAlong(1, cell.y)) continue;
        for (int x = 0; x < 3; ++x) sum += countBefore(0, cell.x, x) * counts[x + 3 * y + 9 * z];
      }
    }
    return sum;
  }

 private:
  int kindAlong(int axis, uint64_t at) const { return at == 0 ? 0 : at + 1 < cells_[axis] ? 1 : 2; }

  /// Returns how many of the first `at` cells along an axis are of a kind.
  uint64_t countBefore(int axis, uint64_t at, int kind) const {
    if (kind == 0) return at > 0 ? 1 : 0;
    if (kind == 1) return std::clamp<uint64_t>(at, 1, cells_[axis] - 1) - 1;
    return at == cells_[axis] ? 1 : 0;
  }
  uint64_t sumOfRow(int y, int z, const CellCounts& counts) const {
    uint64_t sum = 0;
    for (int x = 0; x < 3; ++x) sum += countBefore(0, cells_.x, x) * counts[x + 3 * y + 9 * z];
    return sum;
  }
  uint64_t sumOfLayer(int z, const CellCounts& counts) const {
    uint64_t sum = 0;
    for (int y = 0; y < 3; ++y) sum += countBefore(1, cells_.y, y) * sumOfRow(y, z, counts);
    return sum;
  }

  glm::u64vec3 cells_;
};

class Gyroid final : public SampleModel {
 public:
  Gyroid(const GyroidGrid& grid, const glm::u64vec3& cells, uint64_t seed, AttributeSet attributes)
      : SampleModel(attributes),
        order_(cells),
        cells_(makeGyroidCells(grid)),
        relief_(seed, 3.0 / grid.steps()) {
    for (size_t kind = 0; kind < cells_.size(); ++kind) {
      vertices_[kind] = cells_[kind].vertices.size();
      triangles_[kind] = cells_[kind].triangles.size();
    }
    std::mt19937_64 random(seed);
    for (glm::dvec3& offset : bend_) {
      for (int axis = 0; axis < 3; ++axis) offset[axis] = static_cast<double>(random() >> 40) * 0x1p-16;
    }
  }

  uint64_t vertices() const override { return order_.sum(vertices_); }
  uint64_t triangles() const override { return order_.sum(triangles_); }
  uint64_t blocks() const override { return order_.cells(); }

  void addVertices(uint64_t block, std::vector<SampleVertex>& to) const override {
    const glm::u64vec3 cell = order_.cell(block);
    for (const GyroidCell::Vertex& vertex : cells_[order_.kindOf(cell)].vertices) {
      to.push_back(finished(glm::dvec3(cell), vertex));
    }
  }

  void addTriangles(uint64_t block, std::vector<glm::u32vec3>& to) const override {
    const glm::u64vec3 cell = order_.cell(block);
    std::array<uint64_t, 8> first{};
    std::array<const GyroidCell*, 8> cells{};
    for (unsigned i = 0; i < 8; ++i) {
      const glm::u64vec3 other = cell + glm::u64vec3(i & 1, i >> 1 & 1, i >> 2);
      // Skip neighbours outside the block.
      if (glm::any(glm::greaterThanEqual(other, order_.axes()))) continue;
      first[i] = order_.before(other, vertices_);
      cells[i] = &cells_[order_.kindOf(other)];
    }
    for (const GyroidGrid::Triangle& triangle : cells[0]->triangles) {
      glm::u32vec3 corners;
      for (int i = 0; i < 3; ++i) {
        const auto [neighbour, edge] = triangle[i];
        corners[i] = static_cast<uint32_t>(first[neighbour] + cells[neighbour]->number_of_edge[edge]);
      }
      to.push_back(corners);
    }
  }

 private:
  /// Displaces a vertex along its normal, then scales and bends its position.
  SampleVertex finished(const glm::dvec3& cell, const GyroidCell::Vertex& vertex) const {
    const glm::dvec3 periods = cell + glm::dvec3(vertex.position);
    const glm::dvec3 smooth_normal(vertex.normal);
    const ReliefPoint relief = relief_.atWithGradient(periods);
    const glm::dvec3 along = relief.gradient - glm::dot(relief.gradient, smooth_normal) * smooth_normal;
    const glm::dvec3 size(order_.axes());
    const double longest = std::max({size.x, size.y, size.z});
    glm::dvec3 at = (2.0 * (periods + kRoughness * relief.height * smooth_normal) - size) / longest;
    glm::dvec3 normal = smooth_normal - kRoughness * along;
    bend(at, normal);
    SampleVertex result;
    result.position = at;
    result.normal = glm::normalize(normal);
    result.colour = colour(at, relief, static_cast<double>(vertex.wall));
    result.uv = glm::clamp(glm::vec2(periods) / glm::vec2(size), 0.0f, 1.0f);
    return result;
  }

  /// Shears space along each axis by a function of the other two coordinates. Shears are injective, so the
  /// surface does not intersect itself. Transforms the normal by the inverse transpose.
  void bend(glm::dvec3& at, glm::dvec3& normal) const {
    for (int axis = 0; axis < 3; ++axis) {
      glm::dvec3 where = kBendFrequency * at;
      where[axis] = 0;
      const NoiseSample s = noise<true>(where + bend_[axis], static_cast<uint32_t>(axis));
      glm::dvec3 slope(s.x, s.y, s.z);
      slope[axis] = 0;
      at[axis] += kBend * static_cast<double>(s.value);
      normal -= kBend * kBendFrequency * normal[axis] * slope;
    }
  }

  /// Returns the colour of pale stone, darker in hollows and pores, with rusty stains.
  glm::u8vec3 colour(const glm::dvec3& at, const ReliefPoint& relief, double wall) const {
    const double stain = static_cast<double>(noise<false>(2.3 * at + bend_[0], 11).value);
    const double pale = std::clamp(0.55 + 1.6 * relief.height + 0.25 * relief.fine_height, 0.0, 1.0);
    glm::dvec3 mixed = glm::mix(glm::dvec3(138, 112, 88), glm::dvec3(236, 224, 198), pale);
    mixed = glm::mix(mixed, glm::dvec3(158, 92, 54), std::clamp(1.8 * stain - 0.25, 0.0, 0.7));
    mixed *= 1 - 0.3 * std::min(1.0, wall);
    return glm::u8vec3(glm::clamp(mixed + 0.5, 0.0, 255.0));
  }

  CellOrder order_;
  GyroidCells cells_;
  CellCounts vertices_{}, triangles_{};
  Relief relief_;
  std::array<glm::dvec3, 3> bend_{};
};

struct Choice {
  int steps = 0;
  glm::u64vec3 cells{0};
  uint64_t triangles = 0;
};

/// Finds the largest block with nearly equal sides and at most `triangles` triangles.
Choice largestOf(int steps, uint64_t triangles) {
  const GyroidGrid grid(steps);
  CellCounts counts{};
  for (int kind = 0; kind < GyroidGrid::kCells; ++kind) counts[kind] = grid.triangles(kind).size();
  Choice best;
  for (glm::u64vec3 cells(2);; cells[cells.x == cells.z ? 0 : cells.y == cells.z ? 1 : 2] += 1) {
    const uint64_t count = CellOrder(cells).sum(counts);
    if (count > triangles) return best;
    best = {steps, cells, count};
  }
}

}  // namespace

std::unique_ptr<SampleModel> makeGyroid(uint64_t triangles, uint64_t seed, AttributeSet attributes) {
  const auto about = static_cast<int>(std::lround(std::pow(static_cast<double>(triangles), 0.2)));
  Choice best;
  for (int steps = std::clamp(about - 3, kLeastSteps, kMostSteps - 3);
       steps <= std::clamp(about + 3, kLeastSteps, kMostSteps); ++steps) {
    const Choice choice = largestOf(steps, triangles);
    if (choice.triangles > best.triangles) best = choice;
  }
  return std::make_unique<Gyroid>(GyroidGrid(best.steps), best.cells, seed, attributes);
}

}  // namespace lode::ingest
