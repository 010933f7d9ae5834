#pragma once

#include <cstdint>
#include <optional>

#include <glm/glm.hpp>

#include "client/core/view/view.h"

namespace lode::app {

enum class CameraKind : uint8_t { kOrbit, kFly, kWalk };
constexpr int kCameraKindCount = 3;

/// A view direction as yaw and pitch about an axis that stays upright in the picture.
class Heading {
 public:
  /// @param axis  not 0. If the view looks along it, the view's up gives the direction of yaw 0.
  Heading(const core::View& view, glm::dvec3 axis) noexcept;

  /// Turns left and up, in radians. The pitch is clamped just short of the axis.
  void turn(double left_rad, double up_rad) noexcept;
  glm::dvec3 forward() const noexcept;  ///< unit length, like the next three
  glm::dvec3 level() const noexcept;    ///< forward() without pitch
  glm::dvec3 right() const noexcept;
  glm::dvec3 up() const noexcept;
  glm::dvec3 axis() const noexcept { return axis_; }

 private:
  glm::dvec3 axis_, ahead_, left_;  ///< orthonormal
  double yaw_rad_ = 0, pitch_rad_ = 0;
};

/// Orbits a point, which may be anywhere in the picture: turn, pan and zoom. Model frame, like View. Pure: no
/// clock, no input device.
class OrbitCamera {
 public:
  /// @param start           view to start from; the point lies straight ahead.
  /// @param distance_model  distance from the eye to the point, > 0.
  OrbitCamera(const core::View& start, double distance_model, glm::dvec3 axis) noexcept;

  /// Changes the point, which must be in front of the eye. The view stays.
  void turnAbout(const glm::dvec3& point_model) noexcept;
  /// Starts a flight: turnAbout() the point, then move until it is near and in the middle of the picture.
  void flyTo(const glm::dvec3& point_model) noexcept;
  /// Advances a flight. Any other motion of the camera ends it.
  void advance(double seconds) noexcept;
  bool isFlying() const noexcept { return flight_.has_value(); }

  /// Turns by a drag: 180 degrees per picture height. The model follows the pointer.
  void drag(glm::dvec2 pixels, double height_px) noexcept;
  /// Pans: whatever is at the point's distance follows the pointer.
  void shift(glm::dvec2 pixels, const core::View& view) noexcept;
  /// Zooms: each step forward leaves 85 % of the distance, down to a minimum. The point stays at its pixel.
  void zoom(double steps) noexcept;

  /// Distance to the point along the view direction.
  double distanceModel() const noexcept { return offset_model_.z; }
  /// Sets eye, forward and up of a view.
  void apply(core::View& view) const noexcept;

 private:
  Heading heading_;
  glm::dvec3 point_model_;
  glm::dvec3 offset_model_;  ///< from the eye to the point: right, up, forward
  double closest_model_;
  struct Flight {
    glm::dvec3 from_model, to_model;  ///< offsets
    double elapsed_s = 0;
  };
  std::optional<Flight> flight_;
};

/// Steering of a flying camera: -1 to 1 along its own axes.
struct FlyKeys {
  double right = 0, up = 0, forward = 0;
  bool fast = false;  ///< four times the speed
};

/// Flies: keys move it along its own axes, the mouse turns it, the wheel changes its speed.
/// Model frame, like View. Pure: no clock, no input device.
class FlyCamera {
 public:
  /// @param speed_model  in model units per second.
  FlyCamera(const core::View& start, double speed_model, glm::dvec3 axis) noexcept;

  /// Turns by a drag: one field of view per picture height, so that the point under the pointer follows it.
  void look(glm::dvec2 pixels, const core::View& view) noexcept;
  void move(const FlyKeys& keys, double seconds) noexcept;
  /// Each step forward raises the speed by a quarter, within a factor of 10^4 of the initial speed.
  void changeSpeed(double steps) noexcept;

  double speedModel() const noexcept { return speed_model_; }
  void apply(core::View& view) const noexcept;

 private:
  Heading heading_;
  glm::dvec3 eye_model_;
  double speed_model_, first_speed_model_;
};

}  // namespace lode::app
