#include "server/ingest/measure/farthest_of_lod.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "server/ingest/measure/farthest_in_triangle.h"
#include "server/ingest/mesh/number_table.h"

namespace lode::ingest {
namespace {

/// A triangle whose distance exceeds this share of the largest distance so far is sampled finely.
constexpr float kRefineAboveInLod = 0.8f;
// LODs with at most this many triangles get more steps per edge in the first pass. Their triangles are large,
// so that larger distances may hide between two samples, and few, so that more steps cost little.
constexpr size_t kVeryFewTriangles = 256, kFewTriangles = 1024;
constexpr uint32_t stepsAtFirst(size_t triangles) {
  return triangles <= kVeryFewTriangles ? 8 : triangles <= kFewTriangles ? 4 : 2;
}
constexpr float kManySteps = 1.5f;  ///< number of steps per mean input edge length in the second pass
constexpr uint32_t kMostSteps = 24;
constexpr uint32_t kMostStarts = 64;

/// Lists the input positions that lie on each triangle of an LOD.
class PositionsOnTriangles {
 public:
  PositionsOnTriangles(const SimplifiedMesh& lod, std::span<const SurfaceWalk::Place> places)
      : begin_(lod.mesh.triangles.size() + 1) {
    const auto isOn = [&](size_t position) { return lod.remap[position] != kVanished; };
    for (size_t i = 0; i < places.size(); ++i)
      if (isOn(i)) ++begin_[places[i].triangle];
    uint32_t end = 0;
    for (uint32_t& begin : begin_) begin = end += begin;
    positions_.resize(end);
    for (size_t i = places.size(); i-- > 0;)
      if (isOn(i)) positions_[--begin_[places[i].triangle]] = static_cast<uint32_t>(i);
  }

  std::span<const uint32_t> on(size_t triangle) const {
    return std::span(positions_).subspan(begin_[triangle], begin_[triangle + 1] - begin_[triangle]);
  }

 private:
  std::vector<uint32_t> begin_, positions_;
};

class Measurement {
 public:
  Measurement(const SimplifiedMesh& lod, const LodInput& input, std::span<const SurfaceWalk::Place> places,
              std::span<const uint32_t> sources, float lower_bound)
      : mesh_(lod.mesh), input_(input), starts_(lod, places), sources_(sources), largest_(lower_bound) {}

  float run() {
    of_vertex_.reserve(sources_.size());
    for (uint32_t i = 0; i < sources_.size(); ++i) {
      uint32_t near = sources_[i];
      const bool has_stayed = mesh_.positions[i] == input_.mesh().positions[near];
      of_vertex_.push_back(has_stayed ? 0 : measure(pointOf(i), near, kRefineAboveInLod * largest_));
    }
    std::vector<float> high;
    high.reserve(mesh_.triangles.size());
    const uint32_t few = stepsAtFirst(mesh_.triangles.size());
    edges_.reset(3 * mesh_.triangles.size() / 2);
    for (size_t t = 0; t < mesh_.triangles.size(); ++t) high.push_back(sample(t, few));
    const auto steps = static_cast<uint32_t>(kManySteps * edgesOfInputAlongEdge());
    for (size_t t = 0; t < high.size(); ++t)
      if (high[t] > kRefineAboveInLod * largest_) sampleFinely(t, std::clamp(steps, 2 * few, kMostSteps));
    return largest_;
  }

 private:
  glm::vec3 pointOf(uint32_t position) const { return glm::vec3(unpackPosition(mesh_.positions[position])); }

  float edgesOfInputAlongEdge() const {
    return std::sqrt(static_cast<float>(input_.mesh().triangles.size()) /
                     static_cast<float>(std::max<size_t>(1, mesh_.triangles.size())));
  }

  /// @param near  position of the input at which the walk starts; receives the position at which the walk
  /// ends.
  /// @param tolerance  distances up to this value need not be exact.
  float measure(glm::vec3 point, uint32_t& near, float tolerance) {
    const float walked = input_.walk().distanceAndAdvance(point, near, tolerance);
    if (walked <= largest_) return walked;
    const float exact = searches_++ < kMostSearchesOfInput
                            ? input_.walk().nearestOfAll(point, {walked * walked, walked, 0}).distance
                            : input_.tree().nearest(point, 0, {walked * walked, walked, 0}, effort_).distance;
    largest_ = std::max(largest_, exact);
    return exact;
  }

  /// Returns the position of the input where a walk to `point` should start: the nearest to `point` among
  /// `near` and some of the positions that lie on the triangle.
  uint32_t startFor(glm::vec3 point, size_t triangle, uint32_t near) const {
    const std::vector<PositionCode>& positions = input_.mesh().positions;
    const auto squaredDistance = [&](uint32_t position) {
      const glm::vec3 away = glm::vec3(unpackPosition(positions[position])) - point;
      return glm::dot(away, away);
    };
    float least = squaredDistance(near);
    const std::span<const uint32_t> starts = starts_.on(triangle);
    const size_t stride = 1 + starts.size() / kMostStarts;
    for (size_t i = 0; i < starts.size(); i += stride) {
      const float squared = squaredDistance(starts[i]);
      if (squared >= least) continue;
      least = squared;
      near = starts[i];
    }
    return near;
  }

  glm::u32vec3 cornersOf(size_t triangle) const {
    const glm::u32vec3& t = mesh_.triangles[triangle];
    return {mesh_.wedge_position[t.x], mesh_.wedge_position[t.y], mesh_.wedge_position[t.z]};
  }

  /// Samples a triangle on a grid with `steps` steps along each edge. @return the largest distance.
  float sample(size_t triangle, uint32_t steps) {
    const glm::u32vec3 at = cornersOf(triangle);
    float high = std::max({of_vertex_[at.x], of_vertex_[at.y], of_vertex_[at.z]});
    for (int k = 0; k < 3; ++k) high = std::max(high, sampleEdge({at[k], at[(k + 1) % 3]}, triangle, steps));
    if (steps < 3) return high;  // the grid has no points inside the triangle
    forEachPoint(at, steps, [&](glm::vec3 point, bool is_inside, uint32_t& near) {
      if (is_inside) high = std::max(high, measureOn(triangle, point, near, kRefineAboveInLod * largest_));
    });
    return high;
  }

  /// Samples an edge of a triangle. If the edge was sampled with its other triangle, returns that result.
  float sampleEdge(glm::u32vec2 edge, size_t triangle, uint32_t steps) {
    const uint32_t lower = std::min(edge.x, edge.y), upper = std::max(edge.x, edge.y);
    const auto next = static_cast<uint32_t>(of_edge_.size());
    const uint32_t number = edges_.findOrAdd(uint64_t{lower} << 32 | upper, next);
    if (number != next) return of_edge_[number];
    const glm::vec3 from = pointOf(lower), to = pointOf(upper);
    float high = 0;
    uint32_t near = sources_[lower];
    for (uint32_t i = 1; i < steps; ++i) {
      const glm::vec3 point = glm::mix(from, to, static_cast<float>(i) / static_cast<float>(steps));
      high = std::max(high, measureOn(triangle, point, near, kRefineAboveInLod * largest_));
    }
    of_edge_.push_back(high);
    return high;
  }

  void sampleFinely(size_t triangle, uint32_t steps) {
    forEachPoint(cornersOf(triangle), steps,
                 [&](glm::vec3 point, bool, uint32_t& near) { measureOn(triangle, point, near, largest_); });
  }

  /// @param near  input position at which the walk may start; receives the position at which the walk ends.
  float measureOn(size_t triangle, glm::vec3 point, uint32_t& near, float tolerance) {
    near = startFor(point, triangle, near);
    return measure(point, near, tolerance);
  }

  /// Calls visit(point, is_inside, near) for the grid points of a triangle except its corners, row by row.
  /// visit() may change `near`, which the call for the next point of the row receives. The first call of a
  /// row receives the `near` of the previous row's first call.
  template <typename Visit>
  void forEachPoint(const glm::u32vec3& corners, uint32_t steps, Visit&& visit) {
    const glm::vec3 a = pointOf(corners.x), b = pointOf(corners.y), c = pointOf(corners.z);
    uint32_t near_row = sources_[corners.z];
    for (uint32_t i = 0; i < steps; ++i) {
      uint32_t near = near_row;
      for (uint32_t j = 0; i + j <= steps; ++j) {
        const uint32_t k = steps - i - j;
        const bool is_corner = j == steps || k == steps;
        if (is_corner) continue;
        const glm::vec3 sum =
            static_cast<float>(i) * a + static_cast<float>(j) * b + static_cast<float>(k) * c;
        visit(sum / static_cast<float>(steps), i > 0 && j > 0 && k > 0, near);
        if (j == 0) near_row = near;
      }
    }
  }

  const NodeMesh& mesh_;
  const LodInput& input_;
  const PositionsOnTriangles starts_;
  const std::span<const uint32_t> sources_;
  float largest_;
  int searches_ = 0;
  SearchEffort effort_;
  std::vector<float> of_vertex_, of_edge_;
  NumberTable edges_;  ///< maps an edge to an index in of_edge_
};

constexpr float kEdgePrecision = 1.02f;
constexpr int kMostCuts = 12;  ///< largest number of nested bisections of an edge

class EdgeMeasurement {
 public:
  EdgeMeasurement(const SimplifiedMesh& lod, const LodInput& input, std::span<const uint32_t> sources,
                  float lower_bound)
      : mesh_(lod.mesh), input_(input), largest_(lower_bound) {
    corners_.reserve(sources.size());
    for (size_t i = 0; i < sources.size(); ++i) {
      const glm::vec3 at(unpackPosition(mesh_.positions[i]));
      corners_.push_back(measure(at, input_.walk().placeAt(sources[i]).triangle));
    }
  }

  float run() {
    NumberTable edges;
    edges.reset(3 * mesh_.triangles.size() / 2);
    uint32_t next = 0;
    for (const glm::u32vec3& t : mesh_.triangles) {
      for (int k = 0; k < 3; ++k) {
        const uint32_t a = mesh_.wedge_position[t[k]], b = mesh_.wedge_position[t[(k + 1) % 3]];
        const uint64_t edge = uint64_t{std::min(a, b)} << 32 | std::max(a, b);
        if (edges.findOrAdd(edge, next) != next) continue;
        ++next;
        process(corners_[a], corners_[b], 0);
      }
    }
    return largest_;
  }

 private:
  float limit() const { return kEdgePrecision * largest_; }

  MeasuredPoint measure(glm::vec3 at, uint32_t hint) {
    const SurfaceWalk& walk = input_.walk();
    float distance = std::sqrt(walk.squaredDistance(at, hint));
    if (distance > largest_) distance = walk.distanceFrom(at, hint, largest_);
    if (distance > largest_) {
      const TriangleTree::Nearest walked{distance * distance, distance, hint};
      const TriangleTree::Nearest nearest = searches_++ < kMostSearchesOfInput
                                                ? walk.nearestOfAll(at, walked)
                                                : input_.tree().nearest(at, largest_, walked, effort_);
      distance = nearest.distance;
      hint = nearest.triangle;
    }
    largest_ = std::max(largest_, distance);
    return {at, distance, hint};
  }

  void process(const MeasuredPoint& from, const MeasuredPoint& to, int cuts) {
    if (isNear(from, to) || cuts == kMostCuts) return;
    const MeasuredPoint middle = measure(glm::mix(from.at, to.at, 0.5f), from.triangle);
    process(from, middle, cuts + 1);
    process(middle, to, cuts + 1);
  }

  /// Returns true if the segment between two points is known to be within limit() of the input. One of two
  /// conditions suffices. Either one triangle is within limit() of both ends, and so of all points between
  /// them, because the distance from a triangle is convex. Or a chain of neighbouring triangles leads from
  /// one end to the other, and the segment is within limit() of each edge that two of them share.
  bool isNear(const MeasuredPoint& from, const MeasuredPoint& to) const {
    const float squared = limit() * limit();
    const SurfaceWalk& walk = input_.walk();
    if (walk.squaredDistance(to.at, from.triangle) <= squared ||
        walk.squaredDistance(from.at, to.triangle) <= squared)
      return true;
    TriangleChain chain;
    const Segment segment{from.at, to.at};
    if (!walk.chainAlong(segment, from.triangle, to.triangle, squared, chain)) return false;
    const FourSegments sides{{from.at, from.at, from.at, from.at}, {to.at, to.at, to.at, to.at}};
    for (size_t i = 0; i < chain.edge_count; i += 2) {
      const size_t other = std::min(i + 1, chain.edge_count - 1);
      if (anyOf(squaredDistances(chain.eachTwice(i, other), sides) > squared)) return false;
    }
    return true;
  }

  const NodeMesh& mesh_;
  const LodInput& input_;
  float largest_;
  int searches_ = 0;
  SearchEffort effort_;
  std::vector<MeasuredPoint> corners_;
};

}  // namespace

float farthestOfLod(const SimplifiedMesh& lod, const LodInput& input,
                    std::span<const SurfaceWalk::Place> places, std::span<const uint32_t> sources,
                    float lower_bound) {
  return Measurement(lod, input, places, sources, lower_bound).run();
}

float farthestAlongEdges(const SimplifiedMesh& lod, const LodInput& input, std::span<const uint32_t> sources,
                         float lower_bound) {
  return EdgeMeasurement(lod, input, sources, lower_bound).run();
}

}  // namespace lode::ingest
