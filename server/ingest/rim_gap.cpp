#include "server/ingest/rim_gap.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <vector>

namespace lode::ingest {
namespace {

constexpr float kPrecision = 1.02f;
constexpr float kShortestStep = 0.5f;  ///< lattice steps; rims are not divided further

/// A position of the simplified mesh, and a rim of the input with an end that has become it.
struct Meeting {
  uint32_t place, rim;
};

float squaredDistanceToSegment(glm::vec3 point, glm::vec3 a, glm::vec3 b) noexcept {
  const glm::vec3 along = b - a;
  const float length = glm::dot(along, along);
  const float t = length > 0 ? std::clamp(glm::dot(point - a, along) / length, 0.f, 1.f) : 0;
  const glm::vec3 away = point - (a + t * along);
  return glm::dot(away, away);
}

/// The largest distance on a segment, as far as it is larger than one that is known: within kPrecision.
/// @param distanceAt  changes no faster than the place does.
template <typename DistanceAt>
float largestOnSegment(glm::vec3 from, glm::vec3 to, float largest, DistanceAt&& distanceAt) {
  struct Part {
    glm::vec3 from, to;
    float from_distance, to_distance;
  };
  std::vector<Part> parts{{from, to, distanceAt(from), distanceAt(to)}};
  largest = std::max({largest, parts[0].from_distance, parts[0].to_distance});
  while (!parts.empty()) {
    const Part part = parts.back();
    parts.pop_back();
    const float length = glm::distance(part.from, part.to);
    const float at_most = (part.from_distance + part.to_distance + length) / 2;
    if (length <= kShortestStep || at_most <= kPrecision * largest) continue;
    const glm::vec3 middle = (part.from + part.to) / 2.f;
    const float distance = distanceAt(middle);
    largest = std::max(largest, distance);
    parts.push_back({part.from, middle, part.from_distance, distance});
    parts.push_back({middle, part.to, distance, part.to_distance});
  }
  return largest;
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
  const auto nearest = [&](glm::vec3 point, uint32_t place) {
    float squared = std::numeric_limits<float>::infinity();
    auto m = std::partition_point(meetings.begin(), meetings.end(),
                                  [=](Meeting meeting) { return meeting.place < place; });
    for (; m != meetings.end() && m->place == place; ++m) {
      const glm::u32vec2 rim = rims[m->rim];
      squared =
          std::min(squared, squaredDistanceToSegment(point, pointOf(input, rim.x), pointOf(input, rim.y)));
    }
    return squared;
  };
  float largest = 0;
  for (const glm::u32vec2 image : images) {
    const auto gapAt = [&](glm::vec3 point) {
      return std::sqrt(std::min(nearest(point, image.x), nearest(point, image.y)));
    };
    largest = largestOnSegment(pointOf(simplified.mesh, image.x), pointOf(simplified.mesh, image.y), largest,
                               gapAt);
  }
  return largest;
}

}  // namespace lode::ingest
