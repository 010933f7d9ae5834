#pragma once

#include <algorithm>

#include <glm/glm.hpp>

namespace lode::ingest {

/// The place of a triangle with corners a, a + ab and a + ac that is nearest to a point: the shares of ab and
/// of ac.
/// @param ap  from a to the point.
/// Source: Ericson, Real-Time Collision Detection, 2005, 5.1.5.
inline glm::vec2 nearestInTriangle(glm::vec3 ap, glm::vec3 ab, glm::vec3 ac) noexcept {
  const float d1 = glm::dot(ab, ap), d2 = glm::dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return {0, 0};
  const glm::vec3 bp = ap - ab;
  const float d3 = glm::dot(ab, bp), d4 = glm::dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return {1, 0};
  const float vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return {d1 / (d1 - d3), 0};
  const glm::vec3 cp = ap - ac;
  const float d5 = glm::dot(ab, cp), d6 = glm::dot(ac, cp);
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
  const float to_a = glm::dot(ap, ap), to_b = glm::dot(bp, bp), to_c = glm::dot(cp, cp);
  return to_a <= to_b && to_a <= to_c ? glm::vec2(0, 0) : to_b <= to_c ? glm::vec2(1, 0) : glm::vec2(0, 1);
}

/// Square of the distance from a point to a triangle; see nearestInTriangle().
inline float squaredDistanceToTriangle(glm::vec3 ap, glm::vec3 ab, glm::vec3 ac) noexcept {
  const glm::vec2 shares = nearestInTriangle(ap, ab, ac);
  const glm::vec3 away = ap - (shares.x * ab + shares.y * ac);
  return glm::dot(away, away);
}

}  // namespace lode::ingest
