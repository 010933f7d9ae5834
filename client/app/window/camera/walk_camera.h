#pragma once

#include <functional>
#include <optional>

#include <glm/glm.hpp>

#include "client/app/window/camera/cameras.h"
#include "client/core/lod/cut_probe.h"
#include "client/core/view/view.h"

namespace lode::app {

/// The ground below a point, according to the loaded data.
struct Ground {
  double depth_model = 0;        ///< distance from the point straight down to the ground
  double uncertainty_model = 0;  ///< distance by which finer data may move the ground up or down
};
/// Function that returns the ground below a point, or nothing.
using GroundBelow = std::function<std::optional<Ground>(const glm::dvec3& point_model)>;

/// A walking camera. Keys move the camera over the ground at a constant eye height, the mouse turns it, and
/// the wheel changes its speed. The camera does not fall. The camera follows the ground smoothly, even over
/// edges, and keeps its height if there is no ground below. The camera descends only so far that the eye
/// stays above finer data that may load later: see Ground::uncertainty_model. Positions are in the model
/// frame, like those of View. Pure: no clock, no input device.
class WalkCamera {
 public:
  /// @param eye_height_model  initial height of the eye above the ground, > 0. @param axis  up axis.
  WalkCamera(const core::View& start, double eye_height_model, glm::dvec3 axis) noexcept;

  /// Turns by a drag, like FlyCamera::look().
  void look(glm::dvec2 pixels, const core::View& view) noexcept;
  /// Moves the camera horizontally. The keys for up and down change the eye height.
  void move(const FlyKeys& keys, double seconds, const GroundBelow& ground);
  /// Changes the speed, like FlyCamera::changeSpeed().
  void changeSpeed(double steps) noexcept;

  double eyeHeightModel() const noexcept { return height_model_; }
  /// Returns true while the camera still adapts its height to the ground.
  bool isSettling() const noexcept { return is_settling_; }
  void apply(core::View& view) const noexcept;

 private:
  void follow(const std::optional<Ground>& ground, double climb_model, double seconds) noexcept;

  Heading heading_;
  glm::dvec3 eye_model_;
  double height_model_, first_height_model_;
  double speed_factor_ = 1;
  bool is_settling_ = false;
};

/// Finds the ground straight below a point in a cut. Uses the cut's parts, and the fallbacks of missing
/// parts.
/// @param view  view of the camera, whose field of view is used. @param up  up direction, unit length.
std::optional<Ground> groundBelow(const core::CutProbe& probe, const core::View& view,
                                  const glm::dvec3& point_model, const glm::dvec3& up);

}  // namespace lode::app
