#include "server/ingest/measure/triangle_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace lode::ingest {
namespace {

constexpr size_t kTrianglesOfBox = 4;  ///< that are not halved any more
constexpr size_t kMostHalvings = 32;   ///< triangles are numbered in so many bits

}  // namespace

TriangleTree::TriangleTree(const NodeMesh& mesh) : number_(mesh.triangles.size()), place_(number_.size()) {
  if (number_.empty()) return;
  std::vector<Triangle> triangles;
  triangles.reserve(mesh.triangles.size());
  for (const glm::u32vec3& t : mesh.triangles) {
    const auto corner = [&](uint32_t wedge) {
      return glm::vec3(unpackPosition(mesh.positions[mesh.wedge_position[wedge]]));
    };
    const glm::vec3 a = corner(t.x);
    triangles.push_back({a, {corner(t.y) - a, corner(t.z) - a}});
  }
  std::iota(number_.begin(), number_.end(), 0);
  build(triangles, number_, 0);
  triangles_.reserve(triangles.size());
  for (uint32_t i = 0; i < number_.size(); ++i) {
    place_[number_[i]] = i;
    triangles_.push_back(triangles[number_[i]]);
  }
}

/// @param numbers  of a box's triangles; they are brought into the order of the boxes.
/// @param begin  of them in the whole.
void TriangleTree::build(std::span<const Triangle> triangles, std::span<uint32_t> numbers, uint32_t begin) {
  Box box{glm::vec3(kInfinity), glm::vec3(-kInfinity)};
  glm::vec3 low(kInfinity), high(-kInfinity);  // of thrice the middles
  const auto middleOf = [&](uint32_t number) {
    const Triangle& t = triangles[number];
    return 3.f * t.a + t.sides.ab + t.sides.ac;
  };
  for (const uint32_t number : numbers) {
    const Triangle& t = triangles[number];
    const glm::vec3 b = t.a + t.sides.ab, c = t.a + t.sides.ac, middle = middleOf(number);
    box.min = glm::min(box.min, glm::min(t.a, glm::min(b, c)));
    box.max = glm::max(box.max, glm::max(t.a, glm::max(b, c)));
    low = glm::min(low, middle);
    high = glm::max(high, middle);
  }
  const size_t at = boxes_.size();
  boxes_.push_back(box);
  if (numbers.size() <= kTrianglesOfBox) {
    boxes_[at].begin = begin;
    boxes_[at].end = begin + static_cast<uint32_t>(numbers.size());
    return;
  }
  const glm::vec3 size = high - low;
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const size_t half = numbers.size() / 2;
  std::nth_element(numbers.begin(), numbers.begin() + static_cast<ptrdiff_t>(half), numbers.end(),
                   [&](uint32_t i, uint32_t j) {
                     const float of_i = middleOf(i)[axis], of_j = middleOf(j)[axis];
                     return of_i != of_j ? of_i < of_j : i < j;
                   });
  build(triangles, numbers.first(half), begin);
  boxes_[at].second = static_cast<uint32_t>(boxes_.size());
  build(triangles, numbers.subspan(half), begin + static_cast<uint32_t>(half));
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
