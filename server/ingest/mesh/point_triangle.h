#pragma once

#include <algorithm>
#include <limits>

#include <glm/glm.hpp>

namespace lode::ingest {

/// A triangle with corners a, a + ab and a + ac, relative to a.
struct TriangleSides {
  TriangleSides(glm::vec3 to_b, glm::vec3 to_c) noexcept
      : TriangleSides(to_b, to_c, glm::dot(to_b, to_b), glm::dot(to_b, to_c), glm::dot(to_c, to_c)) {}
  /// Makes a triangle from its sides and their dot products.
  TriangleSides(glm::vec3 to_b, glm::vec3 to_c, float b_b, float b_c, float c_c) noexcept
      : ab(to_b), ac(to_c), ab_ab(b_b), ab_ac(b_c), ac_ac(c_c) {}

  glm::vec3 ab, ac;
  float ab_ab, ab_ac, ac_ac;
};

/// A point of a triangle, given by the weights of ab and ac, and its squared distance from the measured
/// point.
struct PlaceInTriangle {
  glm::vec2 shares;
  float squared;
};

/// Returns the point of a triangle that is nearest to a given point. This is the given point's projection if
/// the projection lies inside the triangle, else the nearest point of an edge.
/// @param ap  vector from corner a to the point.
/// Source: Ericson, Real-Time Collision Detection, 2005, section 5.1.5, for the products that classify the
/// point.
inline PlaceInTriangle nearestInTriangle(glm::vec3 ap, const TriangleSides& sides) noexcept {
  const float d1 = glm::dot(sides.ab, ap), d2 = glm::dot(sides.ac, ap), d3 = d1 - sides.ab_ab,
              d4 = d2 - sides.ab_ac, d5 = d1 - sides.ab_ac, d6 = d2 - sides.ac_ac;
  const float vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4, sum = va + vb + vc;
  if (va > 0 && vb > 0 && vc > 0) {
    const glm::vec2 shares(vb / sum, vc / sum);
    const glm::vec3 away = ap - (shares.x * sides.ab + shares.y * sides.ac);
    return {shares, glm::dot(away, away)};
  }
  PlaceInTriangle nearest{{}, std::numeric_limits<float>::infinity()};
  const auto offer = [&](glm::vec2 shares, glm::vec3 away) {
    const float squared = glm::dot(away, away);
    if (squared < nearest.squared) nearest = {shares, squared};
  };
  const auto shareOf = [](float part, float whole) {
    const float share = part / whole;
    return share > 0 ? std::min(share, 1.f) : 0.f;
  };
  const float on_ab = shareOf(d1, sides.ab_ab), on_ac = shareOf(d2, sides.ac_ac),
              on_bc = shareOf(d4 - d3, (d4 - d3) + (d5 - d6));
  offer({on_ab, 0}, ap - on_ab * sides.ab);
  offer({0, on_ac}, ap - on_ac * sides.ac);
  offer({1 - on_bc, on_bc}, ap - sides.ab - on_bc * (sides.ac - sides.ab));
  return nearest;
}

/// Returns the squared distance from a point to a triangle; see nearestInTriangle().
inline float squaredDistanceToTriangle(glm::vec3 ap, const TriangleSides& sides) noexcept {
  return nearestInTriangle(ap, sides).squared;
}

}  // namespace lode::ingest
