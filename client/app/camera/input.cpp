#include "client/app/camera/input.h"

#include <algorithm>

namespace lode::app {
namespace {

/// Fraction of a stick's travel that is ignored, because worn sticks do not return to 0.
constexpr double kDeadZone = 0.2;

double curved(double travel) noexcept {
  const double part = std::clamp((travel - kDeadZone) / (1 - kDeadZone), 0.0, 1.0);
  return part * part;
}

/// Converts a stick's position to motion. Applies the response curve to the length of the deflection, not to
/// x and y separately, because that would change the direction.
glm::dvec2 stick(const glm::dvec2& at) noexcept {
  const double travel = glm::length(at);
  return travel > 0 ? at / travel * curved(travel) : glm::dvec2(0);
}

double trigger(double at) noexcept { return curved((at + 1) / 2); }

}  // namespace

Input withoutTyping(const Input& input) {
  Input kept;
  kept.pointer_px = input.pointer_px;
  kept.any_key = input.any();
  kept.enter = input.enter;
  kept.quit = input.quit;
  kept.toggle_full_screen = input.toggle_full_screen;
  kept.dropped = input.dropped;
  kept.damaged = input.damaged;
  return kept;
}

PadMotion motionOf(const PadAxes& axes) noexcept {
  const glm::dvec2 left = stick(axes.left);
  return {.move = {.right = left.x,
                   .up = trigger(axes.right_trigger) - trigger(axes.left_trigger),
                   .forward = -left.y},
          .turn = stick(axes.right)};
}

}  // namespace lode::app
