#include "client/render/gl/eye.h"

#include <algorithm>
#include <cmath>

namespace lode::render {

SplitEye splitEye(glm::dvec3 eye_model, double step) noexcept {
  constexpr double kLimit = 1 << 30;
  const glm::dvec3 eye = eye_model / step;
  const glm::dvec3 high = glm::clamp(glm::round(eye), -kLimit, kLimit);
  return {glm::ivec3(high), glm::vec3(eye - high)};
}

glm::mat3 viewRotation(const core::View& view) noexcept {
  const glm::dvec3 right = glm::normalize(glm::cross(view.forward, view.up));
  const glm::dvec3 up = glm::cross(right, view.forward);
  return glm::mat3(glm::transpose(glm::dmat3(right, up, -view.forward)));
}

Projection reversedProjection(const core::View& view, double step) noexcept {
  const double scale_y = 1.0 / std::tan(view.fov_y_rad / 2);
  const double aspect = double(view.width_px) / std::max(1u, view.height_px);
  return {glm::vec2(scale_y / aspect, scale_y), static_cast<float>(std::max(view.near_model, step))};
}

}  // namespace lode::render
