#include "client/core/view/view.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lode::core {

ModelBox toModelBox(const LatticeBox& box, double step) noexcept {
  return {glm::dvec3(box.min) * step, glm::dvec3(box.max) * step};
}

double distanceToBox(glm::dvec3 eye_model, const ModelBox& box) noexcept {
  return glm::length(eye_model - glm::clamp(eye_model, box.min, box.max));
}

double focalPx(const View& view) noexcept { return view.height_px / (2 * std::tan(view.fov_y_rad / 2)); }

float screenErrorPx(float error_model, double distance_model, const View& view) noexcept {
  return ViewFrustum(view, 1).errorPx(error_model, distance_model);
}

bool boxMayBeVisible(const ModelBox& box, const View& view, double widening) noexcept {
  const ViewFrustum frustum(view, widening);
  // The test of each pyramid is conservative: a box that lies partly behind the eye may pass the narrower
  // pyramid's test and fail the wider one's. So test both.
  return frustum.test(box) != Visibility::kOutside || (widening > 1 && frustum.isInMargin(box));
}

ViewFrustum::Pyramid::Pyramid(const View& view, double widening) noexcept : eye_model_(view.eye_model) {
  const double tan_y = std::tan(view.fov_y_rad / 2) * widening;
  const double tan_x = tan_y * view.width_px / view.height_px;
  const glm::dvec3 right = glm::cross(view.forward, view.up);
  inward_ = {view.forward, view.forward * tan_x + right, view.forward * tan_x - right,
             view.forward * tan_y + view.up, view.forward * tan_y - view.up};
  for (size_t side = 0; side < inward_.size(); ++side) reach_[side] = glm::abs(inward_[side]);
}

Visibility ViewFrustum::Pyramid::test(const ModelBox& box) const noexcept {
  const glm::dvec3 centre = (box.min + box.max) / 2.0 - eye_model_;
  const glm::dvec3 half = (box.max - box.min) / 2.0;
  bool wholly = true;
  for (size_t side = 0; side < inward_.size(); ++side) {
    const double middle = glm::dot(inward_[side], centre), reach = glm::dot(reach_[side], half);
    if (middle + reach < 0) return Visibility::kOutside;
    wholly = wholly && middle >= reach;
  }
  return wholly ? Visibility::kInside : Visibility::kPartial;
}

ViewFrustum::ViewFrustum(const View& view, double widening) noexcept
    : eye_model_(view.eye_model),
      near_model_(view.near_model),
      focal_px_(focalPx(view)),
      picture_(view, 1),
      wider_(view, widening) {}

std::array<glm::dvec3, 5> ViewFrustum::inwardNormals() const noexcept {
  std::array<glm::dvec3, 5> normals = picture_.inward();
  for (glm::dvec3& normal : normals) normal = glm::normalize(normal);
  return normals;
}

float ViewFrustum::errorPx(float error_model, double distance_model) const noexcept {
  const double error_px =
      static_cast<double>(error_model) * focal_px_ / std::max(distance_model, near_model_);
  return static_cast<float>(std::min(error_px, static_cast<double>(std::numeric_limits<float>::max())));
}

}  // namespace lode::core
