#pragma once

#include <functional>
#include <optional>

#include <glm/glm.hpp>

#include "client/app/window/camera/cameras.h"
#include "client/core/view/view.h"

namespace lode::render {

/// What lies below a point, as far as it is known yet.
struct Ground {
  double depth_model = 0;        ///< straight down from the point
  double uncertainty_model = 0;  ///< by which finer data may show it to be higher or lower
};
/// Nothing where there is no ground.
using GroundBelow = std::function<std::optional<Ground>(const glm::dvec3& point_model)>;

/// Walks: keys move it over the ground, to which its eye keeps a height, the mouse turns it, the wheel sets
/// its speed. It has no weight: it follows the ground smoothly, over an edge too, and where there is none it
/// stays as high as it is. It never goes further down than the ground surely is: what comes in finer never
/// lies above it, and it falls through nothing that is still loading. Model frame, like View. Pure: no clock,
/// no input device.
class WalkCamera {
 public:
  /// @param eye_height_model  > 0. @param axis  up.
  WalkCamera(const core::View& start, double eye_height_model, glm::dvec3 axis) noexcept;

  /// As FlyCamera.
  void look(glm::dvec2 pixels, const core::View& view) noexcept;
  /// Ahead and aside on the level; keys for up and down make it taller or smaller.
  void move(const FlyKeys& keys, double seconds, const GroundBelow& ground);
  /// Each step forward is a quarter faster; the speed stays within a factor of 10^4 of the first.
  void changeSpeed(double steps) noexcept;

  double eyeHeightModel() const noexcept { return height_model_; }
  /// It is on its way up or down.
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

}  // namespace lode::render
