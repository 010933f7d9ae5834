#pragma once

#include <algorithm>
#include <array>

#include <glm/glm.hpp>

namespace lode {

using TriangleCorners = std::array<glm::dvec3, 3>;

/// Returns the point of a segment that is nearest to `point`.
inline glm::dvec3 nearestPointOfSegment(glm::dvec3 point, glm::dvec3 from, glm::dvec3 to) noexcept {
  const glm::dvec3 along = to - from;
  const double squared_length = glm::dot(along, along);
  const double share =
      squared_length > 0 ? std::clamp(glm::dot(point - from, along) / squared_length, 0.0, 1.0) : 0;
  return from + share * along;
}

/// Returns the point of a triangle that is nearest to `point`; exact for triangles of any shape, even if they
/// are a million times as long as wide.
inline glm::dvec3 nearestPointOfTriangle(glm::dvec3 point, const TriangleCorners& triangle) noexcept {
  const auto& [a, b, c] = triangle;
  const glm::dvec3 normal = glm::cross(b - a, c - a);
  const double squared_normal = glm::dot(normal, normal);
  const auto isInside = [&](glm::dvec3 from, glm::dvec3 to) {
    return glm::dot(normal, glm::cross(to - from, point - from)) >= 0;
  };
  if (squared_normal > 0 && isInside(a, b) && isInside(b, c) && isInside(c, a))
    return point - glm::dot(normal, point - a) / squared_normal * normal;
  glm::dvec3 nearest = nearestPointOfSegment(point, a, b);
  for (const glm::dvec3 other : {nearestPointOfSegment(point, b, c), nearestPointOfSegment(point, c, a)})
    if (glm::dot(other - point, other - point) < glm::dot(nearest - point, nearest - point)) nearest = other;
  return nearest;
}

}  // namespace lode
