#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

namespace lode::store {

struct Segment {
  glm::dvec3 from{0}, to{0};
};

/// Distance from points to the nearest of many segments, by a bounding volume tree split at the median of the
/// longest axis. Const functions are thread safe.
class SegmentTree {
 public:
  explicit SegmentTree(std::vector<Segment> segments);

  bool empty() const noexcept { return segments_.empty(); }
  /// @return the distance; infinite without segments.
  double distance(glm::dvec3 point) const;

 private:
  struct Box {
    glm::dvec3 min, max;
    uint32_t first = 0, count = 0;  ///< of the segments below
    uint32_t right = 0;             ///< index of the second child; the first one is the next box; 0: a leaf
  };
  uint32_t build(uint32_t first, uint32_t count);

  std::vector<Segment> segments_;
  std::vector<Box> boxes_;
};

}  // namespace lode::store
