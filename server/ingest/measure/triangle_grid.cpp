#include "server/ingest/measure/triangle_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lode::ingest {
namespace {

constexpr float kMaxCellsAlongAxis = 64;
constexpr uint64_t kMaxCellsOfTriangle = 16;  ///< on average

float squaredLength(glm::vec3 v) noexcept { return glm::dot(v, v); }

}  // namespace

TriangleGrid::TriangleGrid(const NodeMesh& mesh) {
  LatticeBox box;
  for (const PositionCode position : mesh.positions) box.add(unpackPosition(position));
  if (mesh.triangles.empty()) return;
  triangles_.reserve(mesh.triangles.size());
  for (const glm::u32vec3& t : mesh.triangles) {
    const auto corner = [&](uint32_t wedge) {
      return glm::vec3(unpackPosition(mesh.positions[mesh.wedge_position[wedge]]));
    };
    const glm::vec3 a = corner(t.x);
    triangles_.push_back({a, {corner(t.y) - a, corner(t.z) - a}});
  }
  chooseCells(glm::vec3(box.min), glm::vec3(box.max - box.min) + 1.f);
  fillCells();
}

TriangleGrid::Cover TriangleGrid::coverOf(const Triangle& triangle) const noexcept {
  const glm::vec3 b = triangle.a + triangle.sides.ab, c = triangle.a + triangle.sides.ac;
  return {cellOf(glm::min(triangle.a, glm::min(b, c))), cellOf(glm::max(triangle.a, glm::max(b, c)))};
}

/// Cells of about an edge's length; coarser where long triangles would stand in too many of them.
void TriangleGrid::chooseCells(glm::vec3 min, glm::vec3 size) {
  min_ = min;
  const float longest = std::max({size.x, size.y, size.z});
  float along = std::clamp(std::sqrt(static_cast<float>(triangles_.size())) * 0.75f, 1.f, kMaxCellsAlongAxis);
  for (;; along /= 2) {
    cell_ = longest / std::max(along, 1.f);
    cells_per_step_ = 1 / cell_;
    dims_ = glm::max(glm::ivec3(glm::ceil(size / cell_)), 1);
    uint64_t members = 0;
    for (const Triangle& triangle : triangles_) {
      const Cover cover = coverOf(triangle);
      const glm::u64vec3 cells(cover.high - cover.low + 1);
      members += cells.x * cells.y * cells.z;
    }
    if (along <= 1 || members <= kMaxCellsOfTriangle * triangles_.size()) return;
  }
}

/// A triangle stands in 16 cells at most on average, so that what is kept there is its number alone.
void TriangleGrid::fillCells() {
  const auto forCells = [&](const Cover& cover, auto&& visit) {
    for (int z = cover.low.z; z <= cover.high.z; ++z) {
      for (int y = cover.low.y; y <= cover.high.y; ++y) {
        for (int x = cover.low.x; x <= cover.high.x; ++x) visit(indexOf({x, y, z}));
      }
    }
  };
  begin_.assign(static_cast<size_t>(dims_.x) * dims_.y * dims_.z + 1, 0);
  for (const Triangle& triangle : triangles_)
    forCells(coverOf(triangle), [&](size_t cell) { ++begin_[cell]; });
  uint32_t end = 0;
  for (uint32_t& begin : begin_) begin = end += begin;
  members_.resize(end);
  for (auto t = static_cast<uint32_t>(triangles_.size()); t-- > 0;)
    forCells(coverOf(triangles_[t]), [&](size_t cell) { members_[--begin_[cell]] = t; });
  spheres_.reserve(triangles_.size());
  for (const Triangle& triangle : triangles_) {
    const glm::vec3 ab = triangle.sides.ab, ac = triangle.sides.ac;
    const glm::vec3 to_centre = (ab + ac) / 3.f;
    const float radius = std::sqrt(
        std::max({squaredLength(to_centre), squaredLength(ab - to_centre), squaredLength(ac - to_centre)}));
    spheres_.emplace_back(triangle.a + to_centre, radius);
  }
}

TriangleGrid::Nearest TriangleGrid::nearest(glm::vec3 point, float enough, Nearest known) const noexcept {
  if (triangles_.empty()) return known;
  const glm::ivec3 centre = cellOf(point);
  for (int radius = 0;; ++radius) {
    searchShell(point, centre, radius, enough, known);
    if (known.distance <= enough || known.distance <= roomIn(point, centre, radius)) return known;
  }
}

/// How far it is from a point to cells outside the shells up to a radius; infinity if there are none.
float TriangleGrid::roomIn(glm::vec3 point, glm::ivec3 centre, int radius) const noexcept {
  float room = kInfinity;
  const glm::vec3 from_min = point - min_;
  for (int axis = 0; axis < 3; ++axis) {
    const int low = centre[axis] - radius, high = centre[axis] + radius + 1;
    if (low > 0) room = std::min(room, from_min[axis] - static_cast<float>(low) * cell_);
    if (high < dims_[axis]) room = std::min(room, static_cast<float>(high) * cell_ - from_min[axis]);
  }
  return room;
}

glm::ivec3 TriangleGrid::cellOf(glm::vec3 point) const noexcept {
  return glm::clamp(glm::ivec3((point - min_) * cells_per_step_), glm::ivec3(0), dims_ - 1);
}

void TriangleGrid::searchShell(glm::vec3 point, glm::ivec3 centre, int radius, float enough,
                               Nearest& best) const noexcept {
  const glm::ivec3 low = glm::max(centre - radius, 0), high = glm::min(centre + radius, dims_ - 1);
  for (int z = low.z; z <= high.z; ++z) {
    for (int y = low.y; y <= high.y; ++y) {
      const bool is_face = std::abs(z - centre.z) == radius || std::abs(y - centre.y) == radius;
      for (int x = low.x; x <= high.x; ++x) {
        if (is_face || std::abs(x - centre.x) == radius) {
          searchCell(point, {x, y, z}, enough, best);
        } else if (x < centre.x + radius) {
          x = std::min(centre.x + radius, high.x + 1) - 1;
        }
      }
    }
  }
}

void TriangleGrid::searchCell(glm::vec3 point, glm::ivec3 cell, float enough, Nearest& best) const noexcept {
  const size_t index = indexOf(cell);
  const glm::vec3 low = min_ + glm::vec3(cell) * cell_;
  const glm::vec3 outside = glm::max(glm::max(low - point, point - (low + cell_)), 0.f);
  if (squaredLength(outside) > best.squared) return;
  for (uint32_t i = begin_[index]; i < begin_[index + 1] && best.distance > enough; ++i) {
    const uint32_t member = members_[i];
    const glm::vec4& sphere = spheres_[member];
    const float reach = best.distance + sphere.w;
    if (squaredLength(point - glm::vec3(sphere)) > reach * reach) continue;
    const float squared = squaredDistance(point, member);
    if (squared < best.squared) best = {squared, std::sqrt(squared), member};
  }
}

}  // namespace lode::ingest
