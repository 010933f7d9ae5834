#include "client/core/view/view.h"

#include <cmath>

#include "client/core/lod/sight.h"

namespace lode::core {

ModelBox toModelBox(const LatticeBox& box, double step) noexcept {
  return {glm::dvec3(box.min) * step, glm::dvec3(box.max) * step};
}

double distanceToBox(glm::dvec3 eye_model, const ModelBox& box) noexcept {
  return glm::length(eye_model - glm::clamp(eye_model, box.min, box.max));
}

double focalPx(const View& view) noexcept { return view.height_px / (2 * std::tan(view.fov_y_rad / 2)); }

float screenErrorPx(float error_model, double distance_model, const View& view) noexcept {
  return Sight(view, 1).errorPx(error_model, distance_model);
}

bool boxMayBeVisible(const ModelBox& box, const View& view, double widening) noexcept {
  const Sight sight(view, widening);
  // A box around the eye may pass the narrower test alone.
  return sight.see(box) != Seen::kNot || (widening > 1 && sight.maySeeWhenTurned(box));
}

}  // namespace lode::core
