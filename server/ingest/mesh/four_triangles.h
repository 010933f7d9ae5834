#pragma once

#include <limits>

#include <glm/glm.hpp>

#include "server/ingest/mesh/four_vectors.h"
#include "server/ingest/mesh/point_triangle.h"

namespace lode::ingest {

/// A triangle as it lies in memory, for FourTriangles.
class PackedTriangle {
 public:
  /// None: no point has a distance from it, but NaN.
  PackedTriangle() noexcept : a_(fourOf(std::numeric_limits<float>::quiet_NaN())) {}
  PackedTriangle(glm::vec3 a, const TriangleSides& sides) noexcept
      : a_{a.x, a.y, a.z, sides.ab_ab},
        ab_{sides.ab.x, sides.ab.y, sides.ab.z, sides.ab_ac},
        ac_{sides.ac.x, sides.ac.y, sides.ac.z, sides.ac_ac} {}

  /// See squaredDistanceToTriangle().
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

  Four a_, ab_{}, ac_{};  ///< and in the last places the products of the sides
};

/// Four triangles, each to measure a point's distance from.
class FourTriangles {
 public:
  FourTriangles(const PackedTriangle& p, const PackedTriangle& q, const PackedTriangle& r,
                const PackedTriangle& s) noexcept {
    part(p.a_, q.a_, r.a_, s.a_, a_, ab_ab_);
    part(p.ab_, q.ab_, r.ab_, s.ab_, ab_, ab_ac_);
    part(p.ac_, q.ac_, r.ac_, s.ac_, ac_, ac_ac_);
  }
  /// By their corners.
  FourTriangles(const FourVectors& a, const FourVectors& b, const FourVectors& c) noexcept
      : a_(a), ab_(b - a), ac_(c - a), ab_ab_(dot(ab_, ab_)), ab_ac_(dot(ab_, ac_)), ac_ac_(dot(ac_, ac_)) {}

  /// What squaredDistanceToTriangle() says of the first point and triangle, of the second, third and fourth,
  /// to the bit.
  Four squaredDistances(const FourVectors& points) const noexcept;

  const FourVectors& a() const noexcept { return a_; }
  const FourVectors& ab() const noexcept { return ab_; }
  const FourVectors& ac() const noexcept { return ac_; }

 private:
  /// Vectors and what follows each.
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

/// The cases of nearestInTriangle() from the last to the first, each in the place of those before.
inline Four FourTriangles::squaredDistances(const FourVectors& points) const noexcept {
  const Four zero{}, one = fourOf(1);
  const FourVectors ap = points - a_;
  const Four d1 = dot(ab_, ap), d2 = dot(ac_, ap), d3 = d1 - ab_ab_, d4 = d2 - ab_ac_, d5 = d1 - ab_ac_,
             d6 = d2 - ac_ac_;
  const Four vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4, sum = va + vb + vc;
  const Four to_b = ab_ab_ - 2 * d1, to_c = ac_ac_ - 2 * d2;

  const auto inside = sum > 0;
  const auto at_b = to_b <= to_c, at_a = (to_b >= 0) & (to_c >= 0);
  Four of_b = inside ? vb : at_a ? zero : at_b ? one : zero;
  Four of_c = inside ? vc : at_a ? zero : at_b ? zero : one;
  Four all = inside ? sum : one;
  const auto set = [&](auto where, Four b, Four c, Four whole) {
    of_b = where ? b : of_b;
    of_c = where ? c : of_c;
    all = where ? whole : all;
  };
  const Four from_b = d4 - d3, from_c = d5 - d6;
  auto between = (va <= 0) & (from_b >= 0) & (from_c >= 0);
  set(between, zero, from_b, from_b + from_c);
  const auto beside_ac = (vb <= 0) & (d2 >= 0) & (d6 <= 0);
  set(beside_ac, zero, d2, d2 - d6);
  const auto beside_c = (d6 >= 0) & (d5 <= d6);
  set(beside_c, zero, one, one);
  const auto beside_ab = (vc <= 0) & (d1 >= 0) & (d3 <= 0);
  set(beside_ab, d1, zero, d1 - d3);
  const auto beside_b = (d3 >= 0) & (d4 <= d3);
  set(beside_b, one, zero, one);
  const auto beside_a = (d1 <= 0) & (d2 <= 0);
  set(beside_a, zero, zero, one);
  between &= ~(beside_ac | beside_c | beside_ab | beside_b | beside_a);

  const Four share_c = of_c / all, share_b = between ? one - share_c : of_b / all;
  const FourVectors away{ap.x - (share_b * ab_.x + share_c * ac_.x),
                         ap.y - (share_b * ab_.y + share_c * ac_.y),
                         ap.z - (share_b * ab_.z + share_c * ac_.z)};
  return dot(away, away);
}

}  // namespace lode::ingest
