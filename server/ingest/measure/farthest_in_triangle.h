#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <glm/glm.hpp>

namespace lode::ingest {

/// A point beside a triangle of a surface that is near to it.
struct PointBeside {
  glm::vec3 at;
  float distance;     ///< from the triangle: not below that from the surface
  uint32_t triangle;  ///< of the surface
};

/// The largest distance of a triangle's points from a surface, to 2 %. The triangle is cut into parts until
/// one triangle of the surface is near all corners of a part (the distance from a triangle is convex), or the
/// part's size bounds the distance of all its points, or kMostCuts have been made; cuts go where the
/// surface's triangles meet. Source: Tang, Lee & Kim, Interactive Hausdorff Distance Computation for General
/// Polygonal Models, 2009, for these bounds.
/// @tparam Surface  has `float squaredDistance(glm::vec3, uint32_t triangle)` and `PointBeside
/// measure(glm::vec3, uint32_t hint, float enough)`: exact, unless it is at most `enough`.
template <typename Surface>
class FarthestInTriangle {
 public:
  /// @param enough  what is nearer is not told apart. @param known  the largest distance so far.
  FarthestInTriangle(const Surface& surface, float enough, float known)
      : surface_(surface), enough_(enough), largest_(known) {}

  /// @param corners  with distances that are exact, unless they are at most told().
  void look(const std::array<PointBeside, 3>& corners) {
    std::array<Part, kMostCuts + 1> parts;
    size_t count = 0;
    parts[count++] = {corners, 0};
    while (count > 0) {
      const Part part = parts[--count];
      if (isBounded(part)) continue;
      const size_t at = edgeToCut();
      const PointBeside &from = part.corners[at], &to = part.corners[(at + 1) % 3],
                        &apex = part.corners[(at + 2) % 3];
      const glm::vec3 meeting = glm::mix(from.at, to.at, whereToCut(at));
      const PointBeside middle = surface_.measure(meeting, from.triangle, told());
      parts[count++] = {{from, middle, apex}, part.cuts + 1};
      parts[count++] = {{middle, to, apex}, part.cuts + 1};
    }
  }

  /// The largest distance found or known.
  float largest() const noexcept { return largest_; }
  /// Up to which distances need not be exact.
  float told() const noexcept { return std::max(enough_, largest_); }

 private:
  struct Part {
    std::array<PointBeside, 3> corners;
    int cuts;
  };

  bool isBounded(const Part& part) {
    const auto& [a, b, c] = part.corners;
    const float high = std::max({a.distance, b.distance, c.distance});
    if (high > told()) largest_ = high;
    const float limit = std::max(enough_, kPrecision * largest_);
    const float longest =
        std::max({glm::distance(a.at, b.at), glm::distance(b.at, c.at), glm::distance(c.at, a.at)});
    if (part.cuts == kMostCuts || high + kFromCorners * longest <= limit) return true;
    for (size_t by = 0; by < 3; ++by) {
      float farthest = 0;
      for (size_t k = 0; k < 3; ++k) {
        const PointBeside& corner = part.corners[k];
        from_[k][by] = corner.triangle == part.corners[by].triangle
                           ? corner.distance
                           : std::sqrt(surface_.squaredDistance(corner.at, part.corners[by].triangle));
        farthest = std::max(farthest, from_[k][by]);
      }
      if (farthest <= limit) return true;
    }
    return false;
  }

  /// The one along which the ends' triangles of the surface part most.
  size_t edgeToCut() const {
    const auto parting = [&](size_t k) { return from_[k][(k + 1) % 3] + from_[(k + 1) % 3][k]; };
    size_t most = 0;
    for (size_t k = 1; k < 3; ++k)
      if (parting(k) > parting(most)) most = k;
    return most;
  }

  /// Where on an edge the ends' triangles are equally far, if their distances grew evenly.
  float whereToCut(size_t k) const {
    const size_t to = (k + 1) % 3;
    const float of_from = from_[k][to] - from_[k][k], of_to = from_[to][k] - from_[to][to];
    const float sum = of_from + of_to;
    return sum > 0 ? std::clamp(of_from / sum, kLeastShare, 1 - kLeastShare) : 0.5f;
  }

  static constexpr int kMostCuts = 24;
  static constexpr float kPrecision = 1.02f;
  static constexpr float kFromCorners =
      0.5773503f;                               ///< of the longest edge: no point is farther from all three
  static constexpr float kLeastShare = 0.125f;  ///< of an edge

  const Surface& surface_;
  const float enough_;
  float largest_;
  /// Distances of each corner of the part at hand from each corner's triangle of the surface.
  std::array<std::array<float, 3>, 3> from_;
};

}  // namespace lode::ingest
