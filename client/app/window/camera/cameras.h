#pragma once

#include <optional>

#include <glm/glm.hpp>

#include "client/core/view/view.h"

namespace lode::render {

/// A direction as turn and tilt about an axis that stays upright in the picture.
class Heading {
 public:
  /// @param axis  of any length but 0. Where the view looks along it, its up says where is ahead.
  Heading(const core::View& view, glm::dvec3 axis) noexcept;

  /// Turns to the left and up, in radians. The tilt stops just short of the axis.
  void turn(double left_rad, double up_rad) noexcept;
  glm::dvec3 forward() const noexcept;  ///< unit length, as the three below
  glm::dvec3 level() const noexcept;    ///< the same without the tilt
  glm::dvec3 right() const noexcept;
  glm::dvec3 up() const noexcept;
  glm::dvec3 axis() const noexcept { return axis_; }

 private:
  glm::dvec3 axis_, ahead_, left_;  ///< orthonormal
  double yaw_rad_ = 0, pitch_rad_ = 0;
};

/// Turns about a point, wherever in the picture it is: drag to turn, drag otherwise to shift, wheel to come
/// closer. Model frame, like View. Pure: no clock, no input device.
class OrbitCamera {
 public:
  /// @param start         its eye and up; the point lies ahead of it.
  /// @param distance_model  from the eye to the point, > 0.
  OrbitCamera(const core::View& start, double distance_model, glm::dvec3 axis) noexcept;

  /// From now on about another point, which is before the eye. The view stays.
  void turnAbout(const glm::dvec3& point_model) noexcept;
  /// Sets out for a point: turnAbout() it, and come nearer until it is in the middle of the picture.
  void flyTo(const glm::dvec3& point_model) noexcept;
  /// Time passes on a flight. Whatever else moves the camera ends it.
  void advance(double seconds) noexcept;
  bool isFlying() const noexcept { return flight_.has_value(); }

  /// A drag over the picture's height turns by half a circle; the model follows the pointer.
  void drag(glm::dvec2 pixels, double height_px) noexcept;
  /// What is under the pointer, as far away as the point, follows the pointer.
  void shift(glm::dvec2 pixels, const core::View& view) noexcept;
  /// Each step forward leaves 85 % of the distance, down to the closest; the point keeps its place in the
  /// picture.
  void zoom(double steps) noexcept;

  /// Of the point, along the view.
  double distanceModel() const noexcept { return offset_model_.z; }
  /// Places eye, forward and up in a view.
  void apply(core::View& view) const noexcept;

 private:
  Heading heading_;
  glm::dvec3 point_model_;
  glm::dvec3 offset_model_;  ///< of the point from the eye: right, up and ahead
  double closest_model_;
  struct Flight {
    glm::dvec3 from_model, to_model;  ///< offsets
    double elapsed_s = 0;
  };
  std::optional<Flight> flight_;
};

/// What a flying camera is told for a stretch of time: -1, 0 or 1 (or between) along its own axes.
struct FlyKeys {
  double right = 0, up = 0, forward = 0;
  bool fast = false;  ///< four times the speed
};

/// Flies: keys move it along its own axes, the mouse turns it, the wheel sets its speed.
/// Model frame, like View. Pure: no clock, no input device.
class FlyCamera {
 public:
  /// @param speed_model  model units a second.
  FlyCamera(const core::View& start, double speed_model, glm::dvec3 axis) noexcept;

  /// A drag over the picture's height turns by the height's angle: what is under the pointer stays there.
  void look(glm::dvec2 pixels, const core::View& view) noexcept;
  void move(const FlyKeys& keys, double seconds) noexcept;
  /// Each step forward is a quarter faster; the speed stays within a factor of 10^4 of the first.
  void changeSpeed(double steps) noexcept;

  double speedModel() const noexcept { return speed_model_; }
  void apply(core::View& view) const noexcept;

 private:
  Heading heading_;
  glm::dvec3 eye_model_;
  double speed_model_, first_speed_model_;
};

}  // namespace lode::render
