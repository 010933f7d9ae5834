#include "client/app/camera/cameras.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace lode::app {
namespace {

constexpr double kMaxTiltRad = std::numbers::pi / 2 - 1e-3;
/// Smallest distance to the orbited point, relative to the initial distance.
constexpr double kClosestPart = 1e-5;
constexpr double kZoomStep = 0.85;
constexpr double kFlightSeconds = 0.6;
constexpr double kFlightPart = 0.4;  ///< distance after a flight, relative to the distance before it
constexpr double kSpeedStep = 1.25;
constexpr double kSpeedRange = 1e4;
constexpr double kFastFactor = 4;

/// Returns the size of a pixel at a distance, in model units.
double modelPerPixel(const core::View& view, double distance_model) noexcept {
  return 2 * distance_model * std::tan(view.fov_y_rad / 2) / std::max(1u, view.height_px);
}

}  // namespace

Heading::Heading(const core::View& view, glm::dvec3 axis) noexcept : axis_(glm::normalize(axis)) {
  const glm::dvec3 unit = glm::normalize(view.forward);
  const double rise = std::clamp(glm::dot(unit, axis_), -1.0, 1.0);
  const glm::dvec3 level = unit - axis_ * rise;
  ahead_ = glm::normalize(glm::length(level) > 1e-9 ? level : view.up * (rise > 0 ? -1.0 : 1.0));
  left_ = glm::cross(axis_, ahead_);
  pitch_rad_ = std::clamp(std::asin(rise), -kMaxTiltRad, kMaxTiltRad);
}

void Heading::turn(double left_rad, double up_rad) noexcept {
  yaw_rad_ = std::remainder(yaw_rad_ + left_rad, 2 * std::numbers::pi);
  pitch_rad_ = std::clamp(pitch_rad_ + up_rad, -kMaxTiltRad, kMaxTiltRad);
}

glm::dvec3 Heading::level() const noexcept {
  return ahead_ * std::cos(yaw_rad_) + left_ * std::sin(yaw_rad_);
}

glm::dvec3 Heading::forward() const noexcept {
  return level() * std::cos(pitch_rad_) + axis_ * std::sin(pitch_rad_);
}

glm::dvec3 Heading::right() const noexcept {
  return ahead_ * std::sin(yaw_rad_) - left_ * std::cos(yaw_rad_);
}

glm::dvec3 Heading::up() const noexcept { return glm::cross(right(), forward()); }

OrbitCamera::OrbitCamera(const core::View& start, double distance_model, glm::dvec3 axis) noexcept
    : heading_(start, axis),
      point_model_(start.eye_model + start.forward * distance_model),
      offset_model_(0, 0, distance_model),
      closest_model_(distance_model * kClosestPart) {}

void OrbitCamera::turnAbout(const glm::dvec3& point_model) noexcept {
  flight_.reset();
  const glm::dvec3 away = point_model - point_model_;
  offset_model_ += glm::dvec3(glm::dot(away, heading_.right()), glm::dot(away, heading_.up()),
                              glm::dot(away, heading_.forward()));
  offset_model_.z = std::max(offset_model_.z, closest_model_);
  point_model_ = point_model;
}

void OrbitCamera::flyTo(const glm::dvec3& point_model) noexcept {
  turnAbout(point_model);
  const double near_model = std::max(closest_model_, offset_model_.z * kFlightPart);
  flight_ = Flight{offset_model_, {0, 0, near_model}};
}

void OrbitCamera::advance(double seconds) noexcept {
  if (!flight_) return;
  flight_->elapsed_s += seconds;
  const double part = std::min(1.0, flight_->elapsed_s / kFlightSeconds);
  const double eased = part * part * (3 - 2 * part);
  offset_model_ = glm::mix(flight_->from_model, flight_->to_model, eased);
  if (part >= 1) flight_.reset();
}

void OrbitCamera::drag(glm::dvec2 pixels, double height_px) noexcept {
  if (pixels != glm::dvec2(0)) flight_.reset();
  const double rad_per_px = std::numbers::pi / std::max(1.0, height_px);
  heading_.turn(-pixels.x * rad_per_px, -pixels.y * rad_per_px);
}

void OrbitCamera::shift(glm::dvec2 pixels, const core::View& view) noexcept {
  if (pixels != glm::dvec2(0)) flight_.reset();
  const double scale = modelPerPixel(view, offset_model_.z);
  point_model_ += (heading_.up() * pixels.y - heading_.right() * pixels.x) * scale;
}

void OrbitCamera::zoom(double steps) noexcept {
  if (steps != 0) flight_.reset();
  offset_model_ *= std::max(closest_model_ / offset_model_.z, std::pow(kZoomStep, steps));
}

void OrbitCamera::apply(core::View& view) const noexcept {
  view.forward = heading_.forward();
  view.up = heading_.up();
  view.eye_model = point_model_ - heading_.right() * offset_model_.x - view.up * offset_model_.y -
                   view.forward * offset_model_.z;
}

FlyCamera::FlyCamera(const core::View& start, double speed_model, glm::dvec3 axis) noexcept
    : heading_(start, axis),
      eye_model_(start.eye_model),
      speed_model_(speed_model),
      first_speed_model_(speed_model) {}

void FlyCamera::look(glm::dvec2 pixels, const core::View& view) noexcept {
  const double rad_per_px = view.fov_y_rad / std::max(1u, view.height_px);
  heading_.turn(pixels.x * rad_per_px, pixels.y * rad_per_px);
}

void FlyCamera::move(const FlyKeys& keys, double seconds) noexcept {
  const double way_model = speed_model_ * seconds * (keys.fast ? kFastFactor : 1);
  eye_model_ +=
      (heading_.right() * keys.right + heading_.up() * keys.up + heading_.forward() * keys.forward) *
      way_model;
}

void FlyCamera::changeSpeed(double steps) noexcept {
  speed_model_ = std::clamp(speed_model_ * std::pow(kSpeedStep, steps), first_speed_model_ / kSpeedRange,
                            first_speed_model_ * kSpeedRange);
}

void FlyCamera::apply(core::View& view) const noexcept {
  view.forward = heading_.forward();
  view.up = heading_.up();
  view.eye_model = eye_model_;
}

}  // namespace lode::app
