#pragma once

#include <functional>
#include <optional>

#include <glm/glm.hpp>

#include "client/app/camera/cameras.h"
#include "client/core/lod/cut_probe.h"
#include "client/core/view/view.h"

namespace lode::app {

/// The ground below a point, according to the loaded data.
struct Ground {
  double depth_model = 0;        ///< height of the point above the ground
  double uncertainty_model = 0;  ///< distance by which finer data may raise or lower the ground
};
/// Function that returns the ground below a point, or nothing.
using GroundBelow = std::function<std::optional<Ground>(const glm::dvec3& point_model)>;

/// A walking camera. Keys move the camera over the ground at a constant eye height, the mouse turns it, and
/// the wheel changes its speed. The camera follows the ground smoothly, even over edges, and keeps its height
/// where there is no ground below. A descent stops Ground::uncertainty_model above the eye height, because
/// finer data that loads later may raise the ground. Positions are in the model frame, like those of View.
/// Pure: no clock, no input device.
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

/// Finds the ground straight below a point in the cut of a probe. Where parts of the cut are missing, uses
/// their fallbacks (client/core/lod/cut.h).
/// @param view  view that supplies the picture size and the field of view. @param up  up direction, unit
/// length.
std::optional<Ground> groundBelow(const core::CutProbe& probe, const core::View& view,
                                  const glm::dvec3& point_model, const glm::dvec3& up);

}  // namespace lode::app
