#pragma once

#include <glm/glm.hpp>

#include "client/app/window/camera/cameras.h"

namespace lode::app {

/// A gamepad's sticks and triggers as GLFW maps them: -1 to 1, sticks' y down, a released trigger at -1.
struct PadAxes {
  glm::dvec2 left{0}, right{0};
  double left_trigger = -1, right_trigger = -1;
};

/// Camera motion: the left stick moves, the triggers go down and up, the right stick turns.
struct PadMotion {
  render::FlyKeys move;  ///< without `fast`
  glm::dvec2 turn{0};    ///< -1 to 1: to the right, down
};

/// Applies a dead zone and a quadratic curve: half of a stick's travel is a quarter of the speed. Pure.
PadMotion motionOf(const PadAxes& axes) noexcept;

}  // namespace lode::app
