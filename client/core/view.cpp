#include "client/core/view.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

namespace lode::core {

ModelBox toModelBox(const LatticeBox& box, double step) noexcept {
  return {glm::dvec3(box.min) * step, glm::dvec3(box.max) * step};
}

double distanceToBox(glm::dvec3 eye_model, const ModelBox& box) noexcept {
  return glm::length(eye_model - glm::clamp(eye_model, box.min, box.max));
}

float screenErrorPx(float error_model, double distance_model, const View& view) noexcept {
  const double distance = std::max(distance_model, view.near_model);
  const double focal_px = view.height_px / (2 * std::tan(view.fov_y_rad / 2));
  const double error_px = static_cast<double>(error_model) * focal_px / distance;
  return static_cast<float>(std::min(error_px, static_cast<double>(std::numeric_limits<float>::max())));
}

namespace {

bool mayMeetPyramid(const ModelBox& box, const View& view, double tan_x, double tan_y) noexcept {
  const glm::dvec3 centre = (box.min + box.max) / 2.0 - view.eye_model;
  const glm::dvec3 half = (box.max - box.min) / 2.0;
  const glm::dvec3 right = glm::cross(view.forward, view.up);
  // Inward normals of the pyramid's sides, and the plane through the eye; none needs unit length.
  const glm::dvec3 inward[] = {view.forward, view.forward * tan_x + right, view.forward * tan_x - right,
                               view.forward * tan_y + view.up, view.forward * tan_y - view.up};
  return std::all_of(std::begin(inward), std::end(inward), [&](const glm::dvec3& normal) {
    return glm::dot(normal, centre) + glm::dot(glm::abs(normal), half) >= 0;
  });
}

}  // namespace

bool boxMayBeVisible(const ModelBox& box, const View& view, double widening) noexcept {
  const double tan_y = std::tan(view.fov_y_rad / 2);
  const double tan_x = tan_y * view.width_px / view.height_px;
  // A box around the eye may pass the narrower test alone.
  return mayMeetPyramid(box, view, tan_x, tan_y) ||
         (widening > 1 && mayMeetPyramid(box, view, tan_x * widening, tan_y * widening));
}

}  // namespace lode::core
