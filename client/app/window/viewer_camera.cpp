#include <algorithm>

#include "client/app/window/panel/panel_fit.h"
#include "client/app/window/panel/panel_font.h"
#include "client/app/window/viewer.h"

/// What moves the camera.
namespace lode::app {
namespace {

constexpr double kLongestStepS = 0.1;  ///< a flight goes no further in one frame, however long it took

}  // namespace

/// By the panel. A screenshot is the picture that `render` draws.
double Viewer::coveredShare() const {
  if (!isForAPerson() || !content_.visible) return 0;
  const glm::vec2 window_px(window_.widthPx(), window_.heightPx());
  return app::coveredShare(window_px, kTextPx * static_cast<float>(window_.contentScale()));
}

/// Where the pointer is, or the middle of the picture, or straight below the eye.
std::optional<glm::dvec3> Viewer::startOfWalk(const glm::dvec2& pointer_px,
                                              const render::GroundBelow& ground) {
  const core::View& view = rig_->view();
  for (const glm::dvec2& place_px : {pointer_px, glm::dvec2(view.width_px, view.height_px) / 2.0})
    if (const auto hit = under(place_px)) return hit->position_model;
  if (const auto below = ground(view.eye_model)) return view.eye_model - below->depth_model * rig_->up();
  return std::nullopt;
}

void Viewer::moveCamera(const Input& input, double seconds) {
  const core::View before = rig_->view();
  const CameraKind kind_before = rig_->kind();
  const auto ground = [this](const glm::dvec3& point) -> std::optional<render::Ground> {
    return scene_.groundBelow(rig_->view(), point, rig_->up());
  };
  std::optional<glm::dvec3> start;
  if (input.next_camera != 0) start = startOfWalk(input.pointer_px, ground);
  rig_->apply(input, std::min(seconds, kLongestStepS), ground);
  if (start && rig_->kind() != kind_before) rig_->standAt(*start);
  moved_ = rig_->view() != before || rig_->underWay();
}

void Viewer::fly() {
  if (!pilot_) return;
  const Pilot::State state = pilot_->fly(scene_, isTimeOver(), *rig_);
  moved_ = moved_ || state != Pilot::State::kWaiting;
  done_ = done_ || state == Pilot::State::kOver;
}

}  // namespace lode::app
