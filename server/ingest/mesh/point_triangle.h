#pragma once

#include <algorithm>

#include <glm/glm.hpp>

namespace lode::ingest {

/// A triangle with corners a, a + ab and a + ac, wherever a is.
struct TriangleSides {
  TriangleSides(glm::vec3 to_b, glm::vec3 to_c) noexcept
      : TriangleSides(to_b, to_c, glm::dot(to_b, to_b), glm::dot(to_b, to_c), glm::dot(to_c, to_c)) {}
  /// With the products that are known already.
  TriangleSides(glm::vec3 to_b, glm::vec3 to_c, float b_b, float b_c, float c_c) noexcept
      : ab(to_b), ac(to_c), ab_ab(b_b), ab_ac(b_c), ac_ac(c_c) {}

  glm::vec3 ab, ac;
  float ab_ab, ab_ac, ac_ac;
};

/// The place of a triangle that is nearest to a point: the shares of ab and of ac.
/// @param ap  from a to the point.
/// Source: Ericson, Real-Time Collision Detection, 2005, 5.1.5.
inline glm::vec2 nearestInTriangle(glm::vec3 ap, const TriangleSides& sides) noexcept {
  const float d1 = glm::dot(sides.ab, ap), d2 = glm::dot(sides.ac, ap);
  if (d1 <= 0 && d2 <= 0) return {0, 0};
  const float d3 = d1 - sides.ab_ab, d4 = d2 - sides.ab_ac;
  if (d3 >= 0 && d4 <= d3) return {1, 0};
  const float vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return {d1 / (d1 - d3), 0};
  const float d5 = d1 - sides.ab_ac, d6 = d2 - sides.ac_ac;
  if (d6 >= 0 && d5 <= d6) return {0, 1};
  const float vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return {0, d2 / (d2 - d6)};
  const float va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const float share = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {1 - share, share};
  }
  const float sum = va + vb + vc;
  if (sum > 0) return {vb / sum, vc / sum};
  const float to_b = sides.ab_ab - 2 * d1, to_c = sides.ac_ac - 2 * d2;  // squared, less that to a
  return to_b >= 0 && to_c >= 0 ? glm::vec2(0, 0) : to_b <= to_c ? glm::vec2(1, 0) : glm::vec2(0, 1);
}

/// Square of the distance from a point to a triangle; see nearestInTriangle().
inline float squaredDistanceToTriangle(glm::vec3 ap, const TriangleSides& sides) noexcept {
  const glm::vec2 shares = nearestInTriangle(ap, sides);
  const glm::vec3 away = ap - (shares.x * sides.ab + shares.y * sides.ac);
  return glm::dot(away, away);
}

}  // namespace lode::ingest
