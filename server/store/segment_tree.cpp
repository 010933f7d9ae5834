#include "server/store/segment_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/point_segment.h"

namespace lode::store {
namespace {

constexpr uint32_t kLeafSegments = 8;

double squaredDistance(glm::dvec3 min, glm::dvec3 max, glm::dvec3 point) {
  const glm::dvec3 gap = point - glm::clamp(point, min, max);
  return glm::dot(gap, gap);
}

}  // namespace

SegmentTree::SegmentTree(std::vector<Segment> segments) : segments_(std::move(segments)) {
  if (!segments_.empty()) build(0, static_cast<uint32_t>(segments_.size()));
}

uint32_t SegmentTree::build(uint32_t first, uint32_t count) {
  const auto begin = segments_.begin() + first;
  Box box{.min = glm::dvec3(std::numeric_limits<double>::infinity()),
          .max = glm::dvec3(-std::numeric_limits<double>::infinity()),
          .first = first,
          .count = count};
  for (auto segment = begin; segment != begin + count; ++segment) {
    box.min = glm::min(box.min, glm::min(segment->from, segment->to));
    box.max = glm::max(box.max, glm::max(segment->from, segment->to));
  }
  const auto number = static_cast<uint32_t>(boxes_.size());
  boxes_.push_back(box);
  if (count <= kLeafSegments) return number;
  const glm::dvec3 size = box.max - box.min;
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  std::nth_element(begin, begin + count / 2, begin + count, [axis](const Segment& a, const Segment& b) {
    return a.from[axis] + a.to[axis] < b.from[axis] + b.to[axis];
  });
  build(first, count / 2);
  const uint32_t right = build(first + count / 2, count - count / 2);
  boxes_[number].right = right;
  return number;
}

double SegmentTree::distance(glm::dvec3 point) const {
  double best = std::numeric_limits<double>::infinity();
  std::vector<uint32_t> todo;
  if (!boxes_.empty()) todo.push_back(0);
  while (!todo.empty()) {
    const uint32_t number = todo.back();
    const Box& box = boxes_[number];
    todo.pop_back();
    if (squaredDistance(box.min, box.max, point) >= best) continue;
    if (box.right == 0) {
      for (uint32_t i = 0; i < box.count; ++i)
        best = std::min(best, squaredDistanceToSegment(point, segments_[box.first + i].from,
                                                       segments_[box.first + i].to));
      continue;
    }
    uint32_t near = number + 1, far = box.right;
    if (squaredDistance(boxes_[far].min, boxes_[far].max, point) <
        squaredDistance(boxes_[near].min, boxes_[near].max, point))
      std::swap(near, far);
    todo.push_back(far);
    todo.push_back(near);
  }
  return std::sqrt(best);
}

}  // namespace lode::store
