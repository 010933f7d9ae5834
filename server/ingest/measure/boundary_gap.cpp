#include "server/ingest/measure/boundary_gap.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <vector>

#include "common/point_segment.h"
#include "server/ingest/mesh/mesh_edges.h"
#include "server/ingest/mesh/segment_distance.h"

namespace lode::ingest {
namespace {

constexpr float kMargin = 1.001f;  ///< factor that covers rounding errors
constexpr float kBoundaryPrecision = 1.02f;
/// Distance in lattice steps below which no distance matters, because floats are no more precise.
constexpr float kNegligible = 0.25f;
/// Parts of an edge are not divided if they are at most this long, in lattice steps.
constexpr float kShortestPart = 0.5f;
constexpr size_t kFewBoundaries = 16;     ///< up to this number of boundaries, keepNear() does not pay off
constexpr size_t kManyBoundaries = 4096;  ///< number of references that suffices to measure an edge
/// All boundary edges at one position together are compared with about kBoundariesOfPlace references. Each
/// edge gets an equal share, but at least kLeastBoundaries and at most kManyBoundaries.
constexpr size_t kBoundariesOfPlace = 16384, kLeastBoundaries = 64;

/// The index of a reference (a boundary edge of the original, see ReferenceBoundary), and the positions of
/// the simplified mesh that its ends map to: `place` for one end, `other` for the other.
struct Meeting {
  uint32_t place, other, reference;
};

float squaredDistance(glm::vec3 point, std::span<const Segment> boundaries) noexcept {
  float squared = std::numeric_limits<float>::infinity();
  for (const Segment& boundary : boundaries)
    squared = std::min(squared, squaredDistanceToSegment(point, boundary.from, boundary.to));
  return squared;
}

/// Returns an upper bound on the squared distance from any point of `part` to its nearest boundary. The
/// distance to one boundary is convex along the part, so it is largest at one end of the part.
float squaredBound(const Segment& part, std::span<const Segment> boundaries) noexcept {
  float squared = std::numeric_limits<float>::infinity();
  for (const Segment& boundary : boundaries)
    squared = std::min(squared, std::max(squaredDistanceToSegment(part.from, boundary.from, boundary.to),
                                         squaredDistanceToSegment(part.to, boundary.from, boundary.to)));
  return squared;
}

/// Bounds on the largest squared distance.
struct Farthest {
  float reached = 0;  ///< largest squared distance measured
  float at_most = 0;  ///< upper bound on the largest squared distance
};

/// Moves to the front of `boundaries` all those that may be the nearest to some point of `part`.
/// @return their number.
size_t keepNear(const Segment& part, std::span<Segment> boundaries) {
  const glm::vec3 middle = (part.from + part.to) / 2.f;
  const float reach = std::sqrt(squaredDistance(middle, boundaries)) + glm::distance(part.from, part.to);
  const auto far = std::partition(boundaries.begin(), boundaries.end(), [&](const Segment& boundary) {
    return squaredDistanceToSegment(middle, boundary.from, boundary.to) <= reach * reach;
  });
  return static_cast<size_t>(far - boundaries.begin());
}

/// Raises `farthest` to the segment's largest distance from the boundaries, which it finds by bisection.
/// Skips parts that cannot raise it.
void measureSegment(const Segment& segment, std::span<Segment> boundaries, Farthest& farthest) {
  struct Part {
    Segment segment;
    size_t near;  ///< number of boundaries, from the front of the list, that may be nearest
  };
  std::vector<Part> parts{{segment, boundaries.size()}};
  for (const glm::vec3 end : {segment.from, segment.to})
    farthest.reached = std::max(farthest.reached, squaredDistance(end, boundaries));
  while (!parts.empty()) {
    const auto [part, near] = parts.back();
    parts.pop_back();
    const std::span<Segment> near_boundaries = boundaries.first(near);
    const float bound = squaredBound(part, near_boundaries);
    const float tolerance =
        std::max(kBoundaryPrecision * kBoundaryPrecision * farthest.reached, kNegligible * kNegligible);
    if (bound <= tolerance || glm::distance(part.from, part.to) <= kShortestPart) {
      farthest.at_most = std::max(farthest.at_most, bound);
      continue;
    }
    const glm::vec3 middle = (part.from + part.to) / 2.f;
    farthest.reached = std::max(farthest.reached, squaredDistance(middle, near_boundaries));
    const size_t nearer = near > kFewBoundaries ? keepNear(part, near_boundaries) : near;
    parts.push_back({{part.from, middle}, nearer});
    parts.push_back({{middle, part.to}, nearer});
  }
}

/// Finds the references whose ends map to given positions of the simplified mesh.
class MeetingBoundaries {
 public:
  MeetingBoundaries(const SimplifiedMesh& simplified, const LodInput& input) : input_(input) {
    for (uint32_t i = 0; i < input.referenceCount(); ++i) {
      const glm::u32vec2 image = imageOf(input.reference(i).near, simplified.remap);
      if (image.x != kVanished) meetings_.push_back({image.x, image.y, i});
      if (image.y != kVanished && image.y != image.x) meetings_.push_back({image.y, image.x, i});
    }
    std::sort(meetings_.begin(), meetings_.end(), [](const Meeting& m, const Meeting& n) {
      return std::tie(m.place, m.other, m.reference) < std::tie(n.place, n.other, n.reference);
    });
  }

  /// Collects the references with an end that maps to an end of the edge, about `most` of them per end. If
  /// there are more, takes those with both ends mapped to ends of the edge, or any if there are none.
  void gather(glm::u32vec2 ends, size_t most, std::vector<Segment>& boundaries) const {
    boundaries.clear();
    for (const uint32_t place : {ends.x, ends.y}) {
      if (boundaries.size() >= kManyBoundaries) break;
      const std::span<const Meeting> all = meetingsAt(place);
      if (most >= kManyBoundaries || all.size() <= most) {
        add(all, boundaries);
        continue;
      }
      for (const uint32_t other : {ends.x, ends.y}) add(withOther(all, other, most), boundaries);
      if (boundaries.empty()) add(all.first(most), boundaries);
    }
  }

  /// Collects references as gather() does, then adds references at positions next to the edge: those that a
  /// reference connects to one of its ends. Stops at about `most` references.
  void gatherAround(glm::u32vec2 ends, size_t most, std::vector<Segment>& boundaries) const {
    gather(ends, most, boundaries);
    for (const uint32_t place : around(ends, most)) {
      if (boundaries.size() >= most) break;
      const std::span<const Meeting> all = meetingsAt(place);
      add(most >= kManyBoundaries ? all : all.first(std::min(most, all.size())), boundaries);
    }
  }

 private:
  std::span<const Meeting> meetingsAt(uint32_t place) const {
    const auto first = std::partition_point(meetings_.begin(), meetings_.end(),
                                            [=](const Meeting& meeting) { return meeting.place < place; });
    const auto last = std::partition_point(first, meetings_.end(),
                                           [=](const Meeting& meeting) { return meeting.place == place; });
    return {first, last};
  }

  static std::span<const Meeting> withOther(std::span<const Meeting> all, uint32_t other, size_t most) {
    const auto first = std::partition_point(all.begin(), all.end(),
                                            [=](const Meeting& meeting) { return meeting.other < other; });
    const auto last = std::partition_point(first, all.end(),
                                           [=](const Meeting& meeting) { return meeting.other == other; });
    return {first, std::min(last, first + std::min(static_cast<ptrdiff_t>(most), all.end() - first))};
  }

  void add(std::span<const Meeting> meetings, std::vector<Segment>& boundaries) const {
    const auto pointOf = [](PositionCode position) { return glm::vec3(unpackPosition(position)); };
    for (const Meeting& meeting : meetings) {
      const ReferenceBoundary boundary = input_.reference(meeting.reference);
      boundaries.push_back({pointOf(boundary.from), pointOf(boundary.to)});
    }
  }

  /// Returns the positions that a reference connects to an end of the edge, except the ends themselves. Looks
  /// at about `most` references per end.
  std::vector<uint32_t> around(glm::u32vec2 ends, size_t most) const {
    std::vector<uint32_t> places;
    for (const uint32_t end : {ends.x, ends.y}) {
      const std::span<const Meeting> all = meetingsAt(end);
      for (const Meeting& meeting : most >= kManyBoundaries ? all : all.first(std::min(most, all.size())))
        if (meeting.other != ends.x && meeting.other != ends.y && meeting.other != kVanished)
          places.push_back(meeting.other);
    }
    std::sort(places.begin(), places.end());
    places.erase(std::unique(places.begin(), places.end()), places.end());
    return places;
  }

  const LodInput& input_;
  std::vector<Meeting> meetings_;
};

/// Maps the input's boundary edges to the simplified mesh. Returns the resulting edges, sorted; omits edges
/// that vanished or collapsed.
std::vector<glm::u32vec2> imagesOfBoundaries(const SimplifiedMesh& simplified, const LodInput& input) {
  std::vector<glm::u32vec2> images;
  for (const glm::u32vec2 boundary : input.boundaries()) {
    const auto [a, b] = std::minmax(simplified.remap[boundary.x], simplified.remap[boundary.y]);
    if (a != b && b != kVanished) images.emplace_back(a, b);
  }
  std::sort(images.begin(), images.end(), isBefore);
  images.erase(std::unique(images.begin(), images.end()), images.end());
  return images;
}

}  // namespace

float boundaryGap(const SimplifiedMesh& simplified, const LodInput& input) {
  const auto pointOf = [&](uint32_t place) {
    return glm::vec3(unpackPosition(simplified.mesh.positions[place]));
  };
  const MeetingBoundaries meeting(simplified, input);
  const std::vector<glm::u32vec2> images = imagesOfBoundaries(simplified, input);
  std::vector<uint32_t> edges_at(simplified.mesh.positions.size());
  for (const glm::u32vec2 image : images)
    for (const uint32_t place : {image.x, image.y}) ++edges_at[place];
  std::vector<Segment> boundaries;
  Farthest farthest;
  for (const glm::u32vec2 image : images) {
    const size_t share = kBoundariesOfPlace / std::max(edges_at[image.x], edges_at[image.y]);
    const size_t most = std::clamp(share, kLeastBoundaries, kManyBoundaries);
    const Segment segment{pointOf(image.x), pointOf(image.y)};
    meeting.gather(image, most, boundaries);
    Farthest from_these = farthest;
    measureSegment(segment, boundaries, from_these);
    if (from_these.at_most <= farthest.at_most) continue;
    meeting.gatherAround(image, most, boundaries);
    measureSegment(segment, boundaries, farthest);
  }
  return input.referenceGapSteps() + kMargin * std::sqrt(farthest.at_most);
}

}  // namespace lode::ingest
