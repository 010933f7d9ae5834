#include "server/ingest/measure/rim_gap.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <vector>

#include "common/point_segment.h"
#include "server/ingest/mesh/segment_distance.h"

namespace lode::ingest {
namespace {

constexpr float kRimPrecision = 1.02f;
constexpr float kNegligible = 0.25f;   ///< lattice steps, as far as large coordinates can be told apart
constexpr float kShortestPart = 0.5f;  ///< lattice steps; rims are not divided further

/// A position of the simplified mesh, and a rim of the input with an end that has become it.
struct Meeting {
  uint32_t place, rim;
};

float squaredDistance(glm::vec3 point, std::span<const Segment> rims) noexcept {
  float squared = std::numeric_limits<float>::infinity();
  for (const Segment& rim : rims)
    squared = std::min(squared, squaredDistanceToSegment(point, rim.from, rim.to));
  return squared;
}

/// What no point of a part is farther away than: the distance from one rim is largest at an end of the part.
float squaredBound(const Segment& part, std::span<const Segment> rims) noexcept {
  float squared = std::numeric_limits<float>::infinity();
  for (const Segment& rim : rims)
    squared = std::min(squared, std::max(squaredDistanceToSegment(part.from, rim.from, rim.to),
                                         squaredDistanceToSegment(part.to, rim.from, rim.to)));
  return squared;
}

/// Squared distances.
struct Farthest {
  float reached = 0;  ///< by a point that was looked at
  float at_most = 0;  ///< by any
};

/// Looks for a segment's farthest points from rims, as long as they may be farther than what is known.
void look(const Segment& segment, std::span<const Segment> rims, Farthest& farthest) {
  std::vector<Segment> parts{segment};
  for (const glm::vec3 end : {segment.from, segment.to})
    farthest.reached = std::max(farthest.reached, squaredDistance(end, rims));
  while (!parts.empty()) {
    const Segment part = parts.back();
    parts.pop_back();
    const float bound = squaredBound(part, rims);
    const float enough =
        std::max(kRimPrecision * kRimPrecision * farthest.reached, kNegligible * kNegligible);
    if (bound <= enough || glm::distance(part.from, part.to) <= kShortestPart) {
      farthest.at_most = std::max(farthest.at_most, bound);
      continue;
    }
    const glm::vec3 middle = (part.from + part.to) / 2.f;
    farthest.reached = std::max(farthest.reached, squaredDistance(middle, rims));
    parts.push_back({part.from, middle});
    parts.push_back({middle, part.to});
  }
}

}  // namespace

float rimGap(const SimplifiedMesh& simplified, const NodeMesh& input, std::span<const glm::u32vec2> rims) {
  const auto pointOf = [](const NodeMesh& mesh, uint32_t position) {
    return glm::vec3(unpackPosition(mesh.positions[position]));
  };
  std::vector<glm::u32vec2> images;
  std::vector<Meeting> meetings;
  for (uint32_t rim = 0; rim < rims.size(); ++rim) {
    const uint32_t a = simplified.became[rims[rim].x], b = simplified.became[rims[rim].y];
    for (const uint32_t end : {a, b})
      if (end != kVanished) meetings.push_back({end, rim});
    if (a != b && a != kVanished && b != kVanished) images.emplace_back(std::min(a, b), std::max(a, b));
  }
  const auto by_ends = [](glm::u32vec2 e, glm::u32vec2 f) { return std::tie(e.x, e.y) < std::tie(f.x, f.y); };
  std::sort(images.begin(), images.end(), by_ends);
  images.erase(std::unique(images.begin(), images.end()), images.end());
  std::sort(meetings.begin(), meetings.end(),
            [](Meeting m, Meeting n) { return std::tie(m.place, m.rim) < std::tie(n.place, n.rim); });
  std::vector<Segment> near;
  Farthest farthest;
  for (const glm::u32vec2 image : images) {
    near.clear();
    for (const uint32_t place : {image.x, image.y}) {
      auto m = std::partition_point(meetings.begin(), meetings.end(),
                                    [=](Meeting meeting) { return meeting.place < place; });
      for (; m != meetings.end() && m->place == place; ++m)
        near.push_back({pointOf(input, rims[m->rim].x), pointOf(input, rims[m->rim].y)});
    }
    look({pointOf(simplified.mesh, image.x), pointOf(simplified.mesh, image.y)}, near, farthest);
  }
  return std::sqrt(farthest.at_most);
}

}  // namespace lode::ingest
