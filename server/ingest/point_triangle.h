#pragma once

#include <algorithm>

#include <glm/glm.hpp>

namespace lode::ingest {

/// Square of the distance from a point to the triangle with corners a, a + ab and a + ac.
/// @param ap  from a to the point.
/// Source: Ericson, Real-Time Collision Detection, 2005, 5.1.5.
inline float squaredDistanceToTriangle(glm::vec3 ap, glm::vec3 ab, glm::vec3 ac) noexcept {
  const auto toPoint = [&](glm::vec3 on) {
    const glm::vec3 d = ap - on;
    return glm::dot(d, d);
  };
  const float d1 = glm::dot(ab, ap), d2 = glm::dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return glm::dot(ap, ap);
  const glm::vec3 bp = ap - ab;
  const float d3 = glm::dot(ab, bp), d4 = glm::dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return glm::dot(bp, bp);
  const float vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return toPoint(d1 / (d1 - d3) * ab);
  const glm::vec3 cp = ap - ac;
  const float d5 = glm::dot(ab, cp), d6 = glm::dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return glm::dot(cp, cp);
  const float vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return toPoint(d2 / (d2 - d6) * ac);
  const float va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    return toPoint(ab + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (ac - ab));
  }
  const float sum = va + vb + vc;
  if (!(sum > 0)) return std::min({glm::dot(ap, ap), glm::dot(bp, bp), glm::dot(cp, cp)});
  return toPoint(vb / sum * ab + vc / sum * ac);
}

}  // namespace lode::ingest
