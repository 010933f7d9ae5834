#include "server/ingest/measure/triangle_tree.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace lode::ingest {
namespace {

constexpr size_t kTrianglesOfBox = 4;  ///< that are not halved any more
constexpr size_t kMostHalvings = 32;   ///< triangles are numbered in so many bits

}  // namespace

TriangleTree::TriangleTree(const NodeMesh& mesh) : place_(mesh.triangles.size()) {
  if (place_.empty()) return;
  std::vector<Triangle> triangles;
  std::vector<Middle> middles;
  triangles.reserve(mesh.triangles.size());
  middles.reserve(mesh.triangles.size());
  for (const glm::u32vec3& t : mesh.triangles) {
    const auto corner = [&](uint32_t wedge) {
      return glm::vec3(unpackPosition(mesh.positions[mesh.wedge_position[wedge]]));
    };
    const glm::vec3 a = corner(t.x), ab = corner(t.y) - a, ac = corner(t.z) - a;
    middles.push_back({3.f * a + ab + ac, static_cast<uint32_t>(triangles.size())});
    triangles.push_back({a, {ab, ac}});
  }
  triangles_.reserve(triangles.size());
  number_.reserve(triangles.size());
  build(triangles, middles);
}

/// The box of some triangles and all boxes in it. @param middles  of the triangles, thrice; changes their
/// order.
/// @return its number.
uint32_t TriangleTree::build(std::span<const Triangle> triangles, std::span<Middle> middles) {
  const auto at = static_cast<uint32_t>(boxes_.size());
  boxes_.push_back({glm::vec3(kInfinity), glm::vec3(-kInfinity)});
  if (middles.size() <= kTrianglesOfBox) {
    Box& box = boxes_[at];
    box.begin = static_cast<uint32_t>(triangles_.size());
    box.end = box.begin + static_cast<uint32_t>(middles.size());
    for (const Middle& middle : middles) {
      const Triangle& t = triangles[middle.triangle];
      const glm::vec3 b = t.a + t.sides.ab, c = t.a + t.sides.ac;
      box.min = glm::min(box.min, glm::min(t.a, glm::min(b, c)));
      box.max = glm::max(box.max, glm::max(t.a, glm::max(b, c)));
      place_[middle.triangle] = static_cast<uint32_t>(triangles_.size());
      triangles_.push_back(t);
      number_.push_back(middle.triangle);
    }
    return at;
  }
  glm::vec3 low(kInfinity), high(-kInfinity);
  for (const Middle& middle : middles) {
    low = glm::min(low, middle.at);
    high = glm::max(high, middle.at);
  }
  const glm::vec3 size = high - low;
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const size_t half = middles.size() / 2;
  std::nth_element(middles.begin(), middles.begin() + static_cast<ptrdiff_t>(half), middles.end(),
                   [axis](const Middle& a, const Middle& b) {
                     return a.at[axis] != b.at[axis] ? a.at[axis] < b.at[axis] : a.triangle < b.triangle;
                   });
  const uint32_t first = build(triangles, middles.first(half));
  const uint32_t second = build(triangles, middles.subspan(half));
  boxes_[at] = {glm::min(boxes_[first].min, boxes_[second].min),
                glm::max(boxes_[first].max, boxes_[second].max), second};
  return at;
}

TriangleTree::Nearest TriangleTree::nearest(glm::vec3 point, float enough, Nearest known) const noexcept {
  if (boxes_.empty()) return known;
  struct Waiting {
    uint32_t box;
    float squared;
  };
  std::array<Waiting, kMostHalvings> waiting;
  size_t count = 0;
  const float enough_squared = enough * enough;
  const auto wait = [&](uint32_t box, float squared) {
    if (squared < known.squared) waiting[count++] = {box, squared};
  };
  wait(0, boxes_[0].squaredDistance(point));
  while (count > 0 && known.squared > enough_squared) {
    const auto [number, squared] = waiting[--count];
    if (squared >= known.squared) continue;
    const Box& box = boxes_[number];
    for (uint32_t i = box.begin; i < box.end; ++i) {
      const float found = triangles_[i].squaredDistance(point);
      if (found < known.squared) known = {found, 0, number_[i]};
    }
    if (box.end > 0) continue;
    const float to_first = boxes_[number + 1].squaredDistance(point);
    const float to_second = boxes_[box.second].squaredDistance(point);
    if (to_first <= to_second) {
      wait(box.second, to_second);
      wait(number + 1, to_first);
    } else {
      wait(number + 1, to_first);
      wait(box.second, to_second);
    }
  }
  known.distance = std::sqrt(known.squared);
  return known;
}

}  // namespace lode::ingest
