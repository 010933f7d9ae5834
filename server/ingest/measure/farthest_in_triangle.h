#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <tuple>

#include <glm/glm.hpp>

#include "server/ingest/measure/surface_walk.h"
#include "server/ingest/mesh/four_triangles.h"
#include "server/ingest/mesh/point_triangle.h"

namespace lode::ingest {

/// A point and its distance from a nearby triangle of a surface.
struct MeasuredPoint {
  glm::vec3 at;
  float distance;     ///< distance from the triangle; never less than the distance from the surface
  uint32_t triangle;  ///< index of the triangle in the surface
};

/// Measures the largest distance from a triangle's points to a surface, to 2 %. Divides the triangle into
/// parts, near points where the nearest triangle of the surface changes. Stops dividing a part after
/// kMostCuts cuts, or if the whole part is known to be within limit(). Three conditions show this: one
/// triangle of the surface is within limit() of all corners of the part, because the distance from a triangle
/// is convex; a chain of triangles covers the part (isBoundedByChains()); or the part is so small that no
/// point is much farther away than a corner. Source: Tang, Lee & Kim, Interactive Hausdorff Distance
/// Computation for General Polygonal Models, 2009, for the bounds of a part.
/// @tparam Surface  has `PackedTriangle triangle(uint32_t)`, SurfaceWalk's `chainAlong()`, and `MeasuredPoint
/// measure(glm::vec3, uint32_t hint, float tolerance)`, whose distance is exact unless it is at most
/// `tolerance`.
template <typename Surface>
class FarthestInTriangle {
 public:
  /// @param tolerance  distances up to this value need not be exact. @param lower_bound  initial value of
  /// largest().
  FarthestInTriangle(const Surface& surface, float tolerance, float lower_bound)
      : surface_(surface), tolerance_(tolerance), largest_(lower_bound) {}

  /// Processes one triangle. @param corners  the corners, each with its distance from the surface; distances
  /// up to precision() need not be exact.
  void process(const std::array<MeasuredPoint, 3>& corners) {
    for (const MeasuredPoint& corner : corners) note(corner);
    Part whole{corners, {}, 0};
    if (isBoundedByChains(corners) || isBoundedBySize(corners) || isBoundedByOneTriangle(whole)) return;
    std::array<Part, kMostCuts + 1> parts;
    size_t count = 0;
    parts[count++] = whole;
    while (count > 0) {
      const Part part = parts[--count];
      if (isBounded(part)) continue;
      const size_t at = edgeToCut(part.from);
      const MeasuredPoint &a = part.corners[at], &b = part.corners[(at + 1) % 3];
      const MeasuredPoint middle =
          surface_.measure(glm::mix(a.at, b.at, whereToCut(part.from, at)), a.triangle, precision());
      note(middle);
      const Meeting meeting = meet(part, middle);
      parts[count++] = withMiddle(part, meeting, (at + 1) % 3);
      parts[count++] = withMiddle(part, meeting, at);
    }
  }

  /// Returns the largest distance found, at least lower_bound.
  float largest() const noexcept { return largest_; }
  /// Returns the point at the largest distance; nothing if no distance exceeded lower_bound.
  std::optional<glm::vec3> at() const noexcept { return at_; }
  /// Distances up to this value need not be exact.
  float precision() const noexcept { return std::max(tolerance_, largest_); }

 private:
  /// Distances between the corners of a part and triangles. Element [i][k] is the distance of corner i from
  /// the triangle nearest to corner k.
  using Distances = std::array<std::array<float, 3>, 3>;

  using Corners = std::array<MeasuredPoint, 3>;

  struct Part {
    Corners corners;
    Distances from;
    int cuts;
  };

  /// The point at which a part is cut, the distances from the point to the triangles nearest to the part's
  /// corners, and the distances from these corners to the triangle nearest to the point.
  struct Meeting {
    MeasuredPoint point;
    std::array<float, 3> of_point, of_corners;
  };

  /// Returns true if the triangle nearest to one of the corners is within limit() of all corners. Fills
  /// part.from one triangle after another, and stops at the first success.
  bool isBoundedByOneTriangle(Part& part) const {
    const auto& [a, b, c] = part.corners;
    if (a.triangle == b.triangle && b.triangle == c.triangle) {
      part.from = {{{a.distance, a.distance, a.distance},
                    {b.distance, b.distance, b.distance},
                    {c.distance, c.distance, c.distance}}};
      return isNear(part, 0);
    }
    const auto isNearAfterMeasuring = [&](size_t by, const std::array<float, 3>& squared) {
      for (size_t k = 0; k < 3; ++k) {
        const MeasuredPoint& corner = part.corners[k];
        const bool same = corner.triangle == part.corners[by].triangle;
        part.from[k][by] = same ? corner.distance : std::sqrt(squared[k]);
      }
      return isNear(part, by);
    };
    const PackedTriangle &of_a = surface_.triangle(a.triangle), &of_b = surface_.triangle(b.triangle),
                         &of_c = surface_.triangle(c.triangle);
    const Four of_ab = FourTriangles(of_a, of_a, of_b, of_b).squaredDistances({b.at, c.at, a.at, c.at});
    if (isNearAfterMeasuring(0, {0, of_ab[0], of_ab[1]}) || isNearAfterMeasuring(1, {of_ab[2], 0, of_ab[3]}))
      return true;
    const Four only_c = FourTriangles(of_c, of_c, of_c, of_c).squaredDistances({a.at, b.at, a.at, b.at});
    return isNearAfterMeasuring(2, {only_c[0], only_c[1], 0});
  }

  Meeting meet(const Part& part, const MeasuredPoint& point) const {
    const auto& [a, b, c] = part.corners;
    const PackedTriangle& of_point = surface_.triangle(point.triangle);
    const Four some = FourTriangles(surface_.triangle(a.triangle), surface_.triangle(b.triangle),
                                    surface_.triangle(c.triangle), of_point)
                          .squaredDistances({point.at, point.at, point.at, a.at});
    Meeting meeting{point, {}, {}};
    // Index of a corner that has the same nearest triangle as the point; 3 if no corner has.
    size_t same = 3;
    for (size_t by = 0; by < 3; ++by) {
      if (part.corners[by].triangle == point.triangle) same = by;
      meeting.of_point[by] = same == by ? point.distance : std::sqrt(some[by]);
    }
    if (same < 3) {
      for (size_t k = 0; k < 3; ++k) meeting.of_corners[k] = part.from[k][same];
    } else {
      const Four others =
          FourTriangles(of_point, of_point, of_point, of_point).squaredDistances({b.at, c.at, b.at, c.at});
      meeting.of_corners = {std::sqrt(some[3]), std::sqrt(others[0]), std::sqrt(others[1])};
    }
    return meeting;
  }

  /// Returns a copy of the part with one corner moved to the cut point.
  static Part withMiddle(const Part& part, const Meeting& meeting, size_t corner) {
    Part cut = part;
    cut.corners[corner] = meeting.point;
    cut.from[corner] = meeting.of_point;
    for (size_t k = 0; k < 3; ++k) cut.from[k][corner] = meeting.of_corners[k];
    cut.from[corner][corner] = meeting.point.distance;
    ++cut.cuts;
    return cut;
  }

  /// Returns the ends of side k and the opposite corner.
  static std::tuple<const MeasuredPoint&, const MeasuredPoint&, const MeasuredPoint&> cornersFrom(
      const Corners& corners, size_t k) {
    return {corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]};
  }

  void note(const MeasuredPoint& point) {
    if (point.distance <= precision()) return;
    largest_ = point.distance;
    at_ = point.at;
  }

  /// Parts within this distance are not divided.
  float limit() const { return std::max(tolerance_, kPrecision * largest_); }

  bool isBoundedBySize(const Corners& corners) const {
    const auto& [a, b, c] = corners;
    const float high = std::max({a.distance, b.distance, c.distance});
    const float longest =
        std::max({glm::distance(a.at, b.at), glm::distance(b.at, c.at), glm::distance(c.at, a.at)});
    return high + kFromCorners * longest <= limit();
  }

  /// Returns true if the triangle nearest to corner `by` is within limit() of all corners.
  bool isNear(const Part& part, size_t by) const {
    return std::max({part.from[0][by], part.from[1][by], part.from[2][by]}) <= limit();
  }

  bool isBounded(const Part& part) const {
    return isNear(part, 0) || isNear(part, 1) || isNear(part, 2) || part.cuts == kMostCuts ||
           (part.cuts > 0 && (isBoundedBySize(part.corners) || isBoundedByChains(part.corners)));
  }

  /// Returns true if a chain of neighbouring triangles of the surface is within limit() of the whole part.
  /// The chain follows one side of the part, from the triangle nearest to one end to the triangle nearest to
  /// the other, and passes a triangle near the third corner. Each edge between two triangles of the chain
  /// must be within limit() of the two sides of the part that it crosses. All points between two successive
  /// edges are then within limit() too, because the distance from a triangle is convex. A part above a vertex
  /// of the surface has no such chain. The function then divides the part at a point near the vertex into
  /// three triangles, one at each side, and covers each with the chain along that side.
  bool isBoundedByChains(const Corners& corners) const {
    const size_t first = firstSide(corners);
    std::array<TriangleChain, 3> along;
    bool are_all_found = true;
    for (const size_t k : {first, (first + 1) % 3, (first + 2) % 3}) {
      const auto& [from, to, third] = cornersFrom(corners, k);
      if (!surface_.chainAlong({from.at, to.at}, from.triangle, to.triangle, limit() * limit(), along[k]))
        are_all_found = false;
      else if (along[k].edge_count > 0 && passes(along[k], from.at, third, to.at))
        return true;
    }
    return are_all_found && isBoundedAround(pointNearVertex(corners, along), corners, along);
  }

  bool isBoundedAround(glm::vec3 place, const Corners& corners,
                       const std::array<TriangleChain, 3>& along) const {
    for (size_t k = 0; k < 3; ++k) {
      const auto& [from, to, third] = cornersFrom(corners, k);
      if (!passes(along[k], from.at, {place, 0, kNoTriangle}, to.at)) return false;
    }
    return true;
  }

  /// Returns the point of a part that is nearest to the vertex of the surface around which the chains lead.
  static glm::vec3 pointNearVertex(const Corners& corners, const std::array<TriangleChain, 3>& along) {
    const TriangleChain& longest = *std::max_element(
        along.begin(), along.end(),
        [](const TriangleChain& a, const TriangleChain& b) { return a.edge_count < b.edge_count; });
    const glm::vec3 a = corners[0].at;
    if (longest.edge_count == 0) return a;
    const TriangleSides sides(corners[1].at - a, corners[2].at - a);
    glm::vec3 nearest = a;
    float least = std::numeric_limits<float>::infinity();
    const size_t middle = longest.edge_count / 2;
    for (const Four end : {longest.from[middle], longest.to[middle]}) {
      const glm::vec3 vertex(end[0], end[1], end[2]);
      const glm::vec2 shares = nearestInTriangle(vertex - a, sides).shares;
      const glm::vec3 place = a + shares.x * sides.ab + shares.y * sides.ac, away = vertex - place;
      if (glm::dot(away, away) >= least) continue;
      least = glm::dot(away, away);
      nearest = place;
    }
    return nearest;
  }

  /// Chooses the side whose chain most likely covers the part: a side with an end that has the same nearest
  /// triangle as the third corner. Returns 0 if there is none.
  static size_t firstSide(const Corners& corners) {
    for (size_t k = 0; k < 3; ++k) {
      const auto& [from, to, third] = cornersFrom(corners, k);
      if (third.triangle == from.triangle || third.triangle == to.triangle) return k;
    }
    return 0;
  }

  /// Finds in the chain the triangle nearest to the point or, if the chain lacks it, the first triangle
  /// within the limit of the point. Returns the number of the chain's edges before the found triangle, or
  /// edge_count + 1 if there is none.
  size_t edgesBefore(const TriangleChain& chain, const MeasuredPoint& point, float limit_squared) const {
    for (size_t i = 0; i <= chain.edge_count; ++i)
      if (chain.triangles[i] == point.triangle) return i;
    for (size_t i = 0; i <= chain.edge_count; i += 4) {
      const auto at = [&](size_t k) -> const PackedTriangle& {
        return surface_.triangle(chain.triangles[std::min(i + k, chain.edge_count)]);
      };
      const Four squared = FourTriangles(at(0), at(1), at(2), at(3)).squaredDistances(FourVectors(point.at));
      for (size_t k = 0; k < 4; ++k)
        if (squared[k] <= limit_squared) return i + k;
    }
    return chain.edge_count + 1;
  }

  bool passes(const TriangleChain& chain, glm::vec3 from, const MeasuredPoint& third, glm::vec3 to) const {
    const float limit_squared = limit() * limit();
    const size_t before = edgesBefore(chain, third, limit_squared);
    if (before > chain.edge_count) return false;
    for (size_t i = 0; i < chain.edge_count; i += 2) {
      const size_t next = std::min(i + 1, chain.edge_count - 1);
      const auto end = [&](size_t k) { return k < before ? from : to; };
      const FourSegments sides{{from, third.at, from, third.at}, {to, end(i), to, end(next)}};
      if (anyOf(squaredDistances(chain.eachTwice(i, next), sides) > limit_squared)) return false;
    }
    return true;
  }

  /// Chooses the edge whose ends are farthest from each other's nearest triangles.
  static size_t edgeToCut(const Distances& from) {
    const auto parting = [&](size_t k) { return from[k][(k + 1) % 3] + from[(k + 1) % 3][k]; };
    size_t most = 0;
    for (size_t k = 1; k < 3; ++k)
      if (parting(k) > parting(most)) most = k;
    return most;
  }

  /// Returns where to cut edge k, as a share of its length. Cuts at equal distance from the triangles nearest
  /// to its two ends, assuming that distances change linearly.
  static float whereToCut(const Distances& from, size_t k) {
    const size_t to = (k + 1) % 3;
    const float of_from = from[k][to] - from[k][k], of_to = from[to][k] - from[to][to];
    const float sum = of_from + of_to;
    return sum > 0 ? std::clamp(of_from / sum, kLeastShare, 1 - kLeastShare) : 0.5f;
  }

  static constexpr uint32_t kNoTriangle = ~0u;
  static constexpr int kMostCuts = 24;
  static constexpr float kPrecision = 1.02f;
  /// Largest distance from a point of a triangle to the nearest corner, relative to the longest edge.
  static constexpr float kFromCorners = 0.5773503f;
  static constexpr float kLeastShare = 0.125f;  ///< a cut leaves at least this share of the edge on each side

  const Surface& surface_;
  const float tolerance_;
  float largest_;
  std::optional<glm::vec3> at_;
};

}  // namespace lode::ingest
