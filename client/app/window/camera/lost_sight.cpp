#include "client/app/window/camera/lost_sight.h"

namespace lode::app {
namespace {

constexpr float kDotPx = 8;

}  // namespace

std::string_view lostSightText(const core::ModelBox& model, const core::View& view) {
  if (!core::boxMayBeVisible(model, view)) return "out of the picture: R is the first view";
  const auto size_model = static_cast<float>(glm::distance(model.min, model.max));
  if (core::screenErrorPx(size_model, core::distanceToBox(view.eye_model, model), view) < kDotPx)
    return "a dot from so far away: R is the first view";
  return "";
}

}  // namespace lode::app
