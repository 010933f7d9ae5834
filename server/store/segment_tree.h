#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

namespace lode::store {

struct Segment {
  glm::dvec3 from{0}, to{0};
};

/// Finds the distance from a point to the nearest of many segments, by a tree of bounding boxes. Each box is
/// divided at the median along its longest axis. Const functions are thread safe.
class SegmentTree {
 public:
  explicit SegmentTree(std::vector<Segment> segments);

  bool empty() const noexcept { return segments_.empty(); }
  /// Returns the distance from a point to the nearest segment; infinity if there are no segments.
  double distance(glm::dvec3 point) const;

 private:
  struct Box {
    glm::dvec3 min, max;
    uint32_t first = 0, count = 0;  ///< index range of the segments inside the box
    uint32_t right = 0;  ///< index of the second child, or 0 in a leaf; the first child is the next box
  };
  uint32_t build(uint32_t first, uint32_t count);

  std::vector<Segment> segments_;
  std::vector<Box> boxes_;
};

}  // namespace lode::store
