#pragma once

#include <limits>

#include <glm/glm.hpp>

#include "server/ingest/mesh/four_vectors.h"
#include "server/ingest/mesh/point_triangle.h"

namespace lode::ingest {

/// A triangle in the memory layout of FourTriangles.
class PackedTriangle {
 public:
  /// Makes an empty triangle. Its distance from every point is NaN.
  PackedTriangle() noexcept : a_(fourOf(std::numeric_limits<float>::quiet_NaN())) {}
  PackedTriangle(glm::vec3 a, const TriangleSides& sides) noexcept
      : a_{a.x, a.y, a.z, sides.ab_ab},
        ab_{sides.ab.x, sides.ab.y, sides.ab.z, sides.ab_ac},
        ac_{sides.ac.x, sides.ac.y, sides.ac.z, sides.ac_ac} {}

  /// Returns the result of squaredDistanceToTriangle() for this triangle.
  float squaredDistance(glm::vec3 point) const noexcept {
    return squaredDistanceToTriangle(
        point - glm::vec3(a_[0], a_[1], a_[2]),
        {{ab_[0], ab_[1], ab_[2]}, {ac_[0], ac_[1], ac_[2]}, a_[3], ab_[3], ac_[3]});
  }

  Four a() const noexcept { return a_; }
  Four ab() const noexcept { return ab_; }
  Four ac() const noexcept { return ac_; }

 private:
  friend class FourTriangles;

  Four a_, ab_{}, ac_{};  ///< the fourth components hold the dot products of the sides
};

/// Four triangles for measuring distances with SIMD.
class FourTriangles {
 public:
  FourTriangles(const PackedTriangle& p, const PackedTriangle& q, const PackedTriangle& r,
                const PackedTriangle& s) noexcept {
    part(p.a_, q.a_, r.a_, s.a_, a_, ab_ab_);
    part(p.ab_, q.ab_, r.ab_, s.ab_, ab_, ab_ac_);
    part(p.ac_, q.ac_, r.ac_, s.ac_, ac_, ac_ac_);
  }
  /// Makes triangles from their corners.
  FourTriangles(const FourVectors& a, const FourVectors& b, const FourVectors& c) noexcept
      : a_(a), ab_(b - a), ac_(c - a), ab_ab_(dot(ab_, ab_)), ab_ac_(dot(ab_, ac_)), ac_ac_(dot(ac_, ac_)) {}

  /// Returns the squared distance of each point from its triangle, bit-identical to
  /// squaredDistanceToTriangle().
  Four squaredDistances(const FourVectors& points) const noexcept;

  /// Like squaredDistances(), but infinity for a point that does not project into its triangle.
  Four squaredHeights(const FourVectors& points) const noexcept;

  const FourVectors& a() const noexcept { return a_; }
  const FourVectors& ab() const noexcept { return ab_; }
  const FourVectors& ac() const noexcept { return ac_; }

 private:
  /// Transposes the first three components of the arguments into `vectors`, and collects the fourth in
  /// `last`.
  static void part(Four p, Four q, Four r, Four s, FourVectors& vectors, Four& last) noexcept {
    const Four pq_xy = __builtin_shufflevector(p, q, 0, 4, 1, 5),
               rs_xy = __builtin_shufflevector(r, s, 0, 4, 1, 5),
               pq_zw = __builtin_shufflevector(p, q, 2, 6, 3, 7),
               rs_zw = __builtin_shufflevector(r, s, 2, 6, 3, 7);
    vectors = {__builtin_shufflevector(pq_xy, rs_xy, 0, 1, 4, 5),
               __builtin_shufflevector(pq_xy, rs_xy, 2, 3, 6, 7),
               __builtin_shufflevector(pq_zw, rs_zw, 0, 1, 4, 5)};
    last = __builtin_shufflevector(pq_zw, rs_zw, 2, 3, 6, 7);
  }

  FourVectors a_, ab_, ac_;
  Four ab_ab_, ab_ac_, ac_ac_;
};

inline Four FourTriangles::squaredDistances(const FourVectors& points) const noexcept {
  const FourVectors ap = points - a_, bp = ap - ab_, bc = ac_ - ab_;
  const Four d1 = dot(ab_, ap), d2 = dot(ac_, ap), d3 = d1 - ab_ab_, d4 = d2 - ab_ac_, d5 = d1 - ab_ac_,
             d6 = d2 - ac_ac_;
  const auto fromEdge = [](const FourVectors& from_end, const FourVectors& edge, Four part, Four whole) {
    const FourVectors away = from_end - smaller(larger(part / whole, Four{}), fourOf(1)) * edge;
    return dot(away, away);
  };
  const Four least =
      smaller(fromEdge(ap, ab_, d1, ab_ab_),
              smaller(fromEdge(ap, ac_, d2, ac_ac_), fromEdge(bp, bc, d4 - d3, (d4 - d3) + (d5 - d6))));
  const Four vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4, sum = va + vb + vc;
  const FourVectors away = ap - ((vb / sum) * ab_ + (vc / sum) * ac_);
  const auto is_above = (va > 0) & (vb > 0) & (vc > 0);
  return is_above ? dot(away, away) : least;
}

inline Four FourTriangles::squaredHeights(const FourVectors& points) const noexcept {
  const FourVectors ap = points - a_;
  const Four to_b = dot(ab_, ap), to_c = dot(ac_, ap);
  const Four of_b = ac_ac_ * to_b - ab_ac_ * to_c, of_c = ab_ab_ * to_c - ab_ac_ * to_b,
             all = ab_ab_ * ac_ac_ - ab_ac_ * ab_ac_;
  const FourVectors away = ap - (of_b * ab_ + of_c * ac_) / all;
  const auto is_above = (of_b >= 0) & (of_c >= 0) & (of_b + of_c <= all) & (all > 0);
  return is_above ? dot(away, away) : fourOf(std::numeric_limits<float>::infinity());
}

}  // namespace lode::ingest
