#include "client/app/camera/walk_camera.h"

#include <algorithm>
#include <cmath>

#include "client/core/lod/cut.h"

namespace lode::app {
namespace {

constexpr double kHeightsASecond = 2.5;  ///< initial speed, in eye heights per second
constexpr double kFastWalkFactor = 4;
constexpr double kWalkSpeedStep = 1.25, kWalkSpeedRange = 1e4;
constexpr double kGrowthASecond = 2, kHeightRange = 1e3;
/// Height above the eye from which the search for ground starts, in eye heights.
constexpr double kClimb = 1;
/// Least height above the ground, in eye heights. If the camera is lower, it jumps to this height at once,
/// then rises smoothly.
constexpr double kLeast = 0.25;
constexpr double kSettleS = 0.15;  ///< time constant with which the height adapts
constexpr double kSettled = 1e-3;  ///< height differences below this share of the eye height count as zero

constexpr double kMostUncertain = 0.01;  ///< largest uncertainty, relative to the diagonal of the part's box

/// Returns a cut part's error, limited by kMostUncertain. Without this limit, the camera would float above
/// the ground while the ground is coarse.
double uncertaintyOf(const core::CutPart& part, double step) {
  LatticeBox lattice_box;
  for (const PositionCode code : part.mesh->positions) lattice_box.add(unpackPosition(code));
  const core::ModelBox box = core::toModelBox(lattice_box, step);
  return std::min<double>(part.error_model, kMostUncertain * glm::distance(box.min, box.max));
}

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
  // On a slope of 45 degrees, the ground rises by the distance that the camera moves.
  const double climb_model = kClimb * height_model_ + way_model;
  follow(ground(eye_model_ + heading_.axis() * climb_model), climb_model, seconds);
}

void WalkCamera::follow(const std::optional<Ground>& ground, double climb_model, double seconds) noexcept {
  is_settling_ = false;
  if (!ground) return;
  // The foot's depth below the ground; positive if the ground is above the foot.
  const double foot_model = climb_model + height_model_ - ground->depth_model;
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

std::optional<Ground> groundBelow(const core::CutProbe& probe, const core::View& view,
                                  const glm::dvec3& point_model, const glm::dvec3& up) {
  core::View down = view;
  down.eye_model = point_model;
  down.forward = -up;
  const glm::dvec3 aside = std::abs(up.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  down.up = glm::normalize(aside - up * glm::dot(aside, up));
  const std::optional<core::Hit> hit = probe.cast({point_model, -up}, core::shownParts(*probe.cut(), down));
  if (!hit) return std::nullopt;
  return Ground{hit->distance_model, uncertaintyOf(*hit->part, probe.step())};
}

}  // namespace lode::app
