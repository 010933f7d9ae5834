#pragma once

#include <algorithm>

#include <glm/glm.hpp>

namespace lode {

/// Returns the squared distance from a point to the segment from a to b.
template <typename T>
T squaredDistanceToSegment(const glm::vec<3, T>& point, const glm::vec<3, T>& a,
                           const glm::vec<3, T>& b) noexcept {
  const glm::vec<3, T> along = b - a;
  const T length_squared = glm::dot(along, along);
  const T share =
      length_squared > 0 ? std::clamp(glm::dot(point - a, along) / length_squared, T{0}, T{1}) : T{0};
  const glm::vec<3, T> away = point - (a + share * along);
  return glm::dot(away, away);
}

}  // namespace lode
