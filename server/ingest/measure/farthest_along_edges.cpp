#include "server/ingest/measure/farthest_along_edges.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "server/ingest/measure/farthest_in_triangle.h"
#include "server/ingest/mesh/number_table.h"

namespace lode::ingest {
namespace {

constexpr float kEdgePrecision = 1.02f;
constexpr int kMostCuts = 12;  ///< of an edge, one within another

class EdgeMeasurement {
 public:
  EdgeMeasurement(const SimplifiedMesh& lod, const LodInput& input, std::span<const uint32_t> sources,
                  float known)
      : mesh_(lod.mesh), input_(input), largest_(known) {
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
        look(corners_[a], corners_[b], 0);
      }
    }
    return largest_;
  }

 private:
  float limit() const { return kEdgePrecision * largest_; }

  PointBeside measure(glm::vec3 at, uint32_t hint) {
    const SurfaceWalk& walk = input_.walk();
    float distance = std::sqrt(walk.squaredDistance(at, hint));
    if (distance > largest_) distance = walk.distanceFrom(at, hint, largest_);
    if (distance > largest_) {
      const TriangleTree::Nearest walked{distance * distance, distance, hint};
      const TriangleTree::Nearest nearest = looks_++ < kMostLooksAtInput
                                                ? walk.nearestOfAll(at, walked)
                                                : input_.tree().nearest(at, largest_, walked);
      distance = nearest.distance;
      hint = nearest.triangle;
    }
    largest_ = std::max(largest_, distance);
    return {at, distance, hint};
  }

  void look(const PointBeside& from, const PointBeside& to, int cuts) {
    if (isNear(from, to) || cuts == kMostCuts) return;
    const PointBeside middle = measure(glm::mix(from.at, to.at, 0.5f), from.triangle);
    look(from, middle, cuts + 1);
    look(middle, to, cuts + 1);
  }

  /// Whether all points between two are near the input: both are near one triangle, from which the distance
  /// is convex, or a chain of triangles leads from that of one to that of the other, of which each edge is
  /// near a place between them.
  bool isNear(const PointBeside& from, const PointBeside& to) const {
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
  int looks_ = 0;
  std::vector<PointBeside> corners_;
};

}  // namespace

float farthestAlongEdges(const SimplifiedMesh& lod, const LodInput& input, std::span<const uint32_t> sources,
                         float known) {
  return EdgeMeasurement(lod, input, sources, known).run();
}

}  // namespace lode::ingest
