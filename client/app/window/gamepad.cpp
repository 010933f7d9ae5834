#include "client/app/window/gamepad.h"

#include <algorithm>

namespace lode::app {
namespace {

constexpr double kDeadZone = 0.2;  ///< of a stick's way: worn ones do not come back any better

double curved(double way) noexcept {
  const double part = std::clamp((way - kDeadZone) / (1 - kDeadZone), 0.0, 1.0);
  return part * part;
}

/// By its whole way, not by x and y, so that it keeps its direction.
glm::dvec2 stick(const glm::dvec2& at) noexcept {
  const double way = glm::length(at);
  return way > 0 ? at / way * curved(way) : glm::dvec2(0);
}

double trigger(double at) noexcept { return curved((at + 1) / 2); }

}  // namespace

PadMotion motionOf(const PadAxes& axes) noexcept {
  const glm::dvec2 left = stick(axes.left);
  return {.move = {.right = left.x,
                   .up = trigger(axes.right_trigger) - trigger(axes.left_trigger),
                   .forward = -left.y},
          .turn = stick(axes.right)};
}

}  // namespace lode::app
