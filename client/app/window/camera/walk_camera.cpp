#include "client/app/window/camera/walk_camera.h"

#include <algorithm>
#include <cmath>

namespace lode::render {
namespace {

constexpr double kHeightsASecond = 2.5;  ///< first speed, in heights of the eye
constexpr double kFastWalkFactor = 4;
constexpr double kWalkSpeedStep = 1.25, kWalkSpeedRange = 1e4;
constexpr double kGrowthASecond = 2, kHeightRange = 1e3;
constexpr double kClimb = 1;       ///< heights above the eye up to which ground that rises is noticed
constexpr double kLeast = 0.25;    ///< of the height is kept at once, before the rest is made up smoothly
constexpr double kSettleS = 0.15;  ///< after which a third of a difference in height is left
constexpr double kSettled = 1e-3;  ///< of the height: too little to be seen

}  // namespace

WalkCamera::WalkCamera(const core::View& start, double eye_height_model, glm::dvec3 axis) noexcept
    : heading_(start, axis),
      eye_model_(start.eye_model),
      height_model_(eye_height_model),
      first_height_model_(eye_height_model) {}

void WalkCamera::look(glm::dvec2 pixels, const core::View& view) noexcept {
  const double rad_per_px = view.fov_y_rad / std::max(1u, view.height_px);
  heading_.turn(pixels.x * rad_per_px, pixels.y * rad_per_px);
}

void WalkCamera::changeSpeed(double steps) noexcept {
  speed_factor_ =
      std::clamp(speed_factor_ * std::pow(kWalkSpeedStep, steps), 1 / kWalkSpeedRange, kWalkSpeedRange);
}

void WalkCamera::move(const FlyKeys& keys, double seconds, const GroundBelow& ground) {
  height_model_ = std::clamp(height_model_ * std::pow(kGrowthASecond, keys.up * seconds),
                             first_height_model_ / kHeightRange, first_height_model_ * kHeightRange);
  const double way_model =
      height_model_ * kHeightsASecond * speed_factor_ * seconds * (keys.fast ? kFastWalkFactor : 1);
  eye_model_ += (heading_.right() * keys.right + heading_.level() * keys.forward) * way_model;
  // A slope of 45 degrees rises as far as the step goes.
  const double climb_model = kClimb * height_model_ + way_model;
  follow(ground(eye_model_ + heading_.axis() * climb_model), climb_model, seconds);
}

void WalkCamera::follow(const std::optional<Ground>& ground, double climb_model, double seconds) noexcept {
  is_settling_ = false;
  if (!ground) return;
  const double foot_model = climb_model + height_model_ - ground->depth_model;  // ground above the foot: > 0
  double rise_model = std::max(0.0, foot_model);
  if (foot_model < -ground->uncertainty_model) rise_model = foot_model + ground->uncertainty_model;
  if (std::abs(rise_model) < kSettled * height_model_) return;
  const double at_once_model = std::max(0.0, rise_model - (1 - kLeast) * height_model_);
  const double eased_model = (rise_model - at_once_model) * -std::expm1(-seconds / kSettleS);
  eye_model_ += heading_.axis() * (at_once_model + eased_model);
  is_settling_ = std::abs(rise_model - at_once_model - eased_model) > kSettled * height_model_;
}

void WalkCamera::apply(core::View& view) const noexcept {
  view.forward = heading_.forward();
  view.up = heading_.up();
  view.eye_model = eye_model_;
}

}  // namespace lode::render
