#include "client/app/window/panel/projection.h"

#include <algorithm>
#include <cmath>

namespace lode::app {
namespace {

// Least depth of the projected part of a segment, relative to the depth of the segment's far end. Nearer
// points are clipped, because they would be projected very far outside the picture.
constexpr double kNearest = 1e-3;

double depthOf(const core::View& view, const glm::dvec3& point_model) noexcept {
  return glm::dot(point_model - view.eye_model, view.forward);
}

/// Projects a point that is in front of the eye.
glm::dvec2 project(const core::View& view, const glm::dvec3& point_model) noexcept {
  const double slope_per_px = 2 * std::tan(view.fov_y_rad / 2) / std::max(1u, view.height_px);
  const glm::dvec3 away = point_model - view.eye_model;
  const glm::dvec2 across(glm::dot(away, glm::cross(view.forward, view.up)), -glm::dot(away, view.up));
  return glm::dvec2(view.width_px, view.height_px) / 2.0 +
         across / (depthOf(view, point_model) * slope_per_px);
}

}  // namespace

std::optional<glm::dvec2> pointInPicture(const core::View& view, const glm::dvec3& point_model) noexcept {
  if (!(depthOf(view, point_model) >= view.near_model)) return std::nullopt;
  return project(view, point_model);
}

std::optional<PictureLine> lineInPicture(const core::View& view, const glm::dvec3& from_model,
                                         const glm::dvec3& to_model) noexcept {
  const double from = depthOf(view, from_model), to = depthOf(view, to_model);
  const double nearest = std::max(view.near_model, kNearest * std::max(from, to));
  if (!(std::max(from, to) >= nearest)) return std::nullopt;
  const auto inFront = [&](const glm::dvec3& point, double depth, const glm::dvec3& other, double of_other) {
    return depth >= nearest ? point : glm::mix(point, other, (nearest - depth) / (of_other - depth));
  };
  return PictureLine{project(view, inFront(from_model, from, to_model, to)),
                     project(view, inFront(to_model, to, from_model, from))};
}

}  // namespace lode::app
