#pragma once

#include <cstdint>
#include <optional>

#include <glm/glm.hpp>

#include "client/core/view/view.h"

namespace lode::app {

enum class CameraKind : uint8_t { kOrbit, kFly, kWalk };
constexpr int kCameraKindCount = 3;

/// A view direction, stored as yaw and pitch relative to an up axis. The up axis stays vertical in the
/// picture.
class Heading {
 public:
  /// @param axis  up axis, not 0. If the view looks along the axis, the view's up vector determines yaw 0.
  Heading(const core::View& view, glm::dvec3 axis) noexcept;

  /// Turns left and up, in radians. Limits the pitch, so that the direction is never parallel to the axis.
  void turn(double left_rad, double up_rad) noexcept;
  glm::dvec3 forward() const noexcept;  ///< view direction; unit length
  glm::dvec3 level() const noexcept;    ///< horizontal part of the view direction
  glm::dvec3 right() const noexcept;
  glm::dvec3 up() const noexcept;
  glm::dvec3 axis() const noexcept { return axis_; }

 private:
  glm::dvec3 axis_, ahead_, left_;  ///< orthonormal
  double yaw_rad_ = 0, pitch_rad_ = 0;
};

/// A camera that orbits a point: it turns, pans and zooms. The point may be anywhere in the picture.
/// Positions are in the model frame, like those of View. Pure: no clock, no input device.
class OrbitCamera {
 public:
  /// @param start           initial view. The point lies straight ahead.
  /// @param distance_model  distance from the eye to the point, > 0.
  OrbitCamera(const core::View& start, double distance_model, glm::dvec3 axis) noexcept;

  /// Chooses a new point to orbit, which must be in front of the eye. The view stays the same.
  void turnAbout(const glm::dvec3& point_model) noexcept;
  /// Starts a flight to a point: calls turnAbout(). Then advance() moves the camera until the point is near
  /// and at the centre of the picture.
  void flyTo(const glm::dvec3& point_model) noexcept;
  /// Advances a flight. Any other motion of the camera ends the flight.
  void advance(double seconds) noexcept;
  bool isFlying() const noexcept { return flight_.has_value(); }

  /// Turns the camera by a drag: 180 degrees per picture height. The model follows the pointer.
  void drag(glm::dvec2 pixels, double height_px) noexcept;
  /// Pans the camera by a drag. Surfaces at the distance of the orbited point follow the pointer.
  void shift(glm::dvec2 pixels, const core::View& view) noexcept;
  /// Zooms. Each forward step multiplies the distance to the orbited point by 0.85, down to a minimum. The
  /// point stays at the same pixel.
  void zoom(double steps) noexcept;

  const glm::dvec3& pointModel() const noexcept { return point_model_; }
  /// Returns the distance to the orbited point along the view direction.
  double distanceModel() const noexcept { return offset_model_.z; }
  /// Sets eye, forward and up of a view.
  void apply(core::View& view) const noexcept;

 private:
  Heading heading_;
  glm::dvec3 point_model_;
  glm::dvec3 offset_model_;  ///< vector from the eye to point_model_; x is right, y up, z forward
  double closest_model_;
  struct Flight {
    glm::dvec3 from_model, to_model;  ///< offset_model_ at the start and at the end of the flight
    double elapsed_s = 0;
  };
  std::optional<Flight> flight_;
};

/// Steering of a flying camera, from -1 to 1 along each of the camera's axes.
struct FlyKeys {
  double right = 0, up = 0, forward = 0;
  bool fast = false;  ///< true to move at four times the speed
};

/// A flying camera. Keys move the camera along its own axes, the mouse turns it, and the wheel changes its
/// speed. Positions are in the model frame, like those of View. Pure: no clock, no input device.
class FlyCamera {
 public:
  /// @param speed_model  initial speed in model units per second.
  FlyCamera(const core::View& start, double speed_model, glm::dvec3 axis) noexcept;

  /// Turns the camera by a drag: one field of view per picture height, so that the picture follows the
  /// pointer.
  void look(glm::dvec2 pixels, const core::View& view) noexcept;
  void move(const FlyKeys& keys, double seconds) noexcept;
  /// Changes the speed. Each forward step raises the speed by 25 %. The speed stays within a factor of 10^4
  /// of the initial speed.
  void changeSpeed(double steps) noexcept;

  double speedModel() const noexcept { return speed_model_; }
  void apply(core::View& view) const noexcept;

 private:
  Heading heading_;
  glm::dvec3 eye_model_;
  double speed_model_, first_speed_model_;
};

}  // namespace lode::app
