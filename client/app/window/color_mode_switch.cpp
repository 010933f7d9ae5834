#include "client/app/window/color_mode_switch.h"

namespace lode::app {

void ColorModeSwitch::step(int steps) noexcept {
  const int next = static_cast<int>(shown_) + steps % render::kColorModeCount + render::kColorModeCount;
  shown_ = static_cast<render::ColorMode>(next % render::kColorModeCount);
}

void ColorModeSwitch::toggleWireframe() noexcept {
  const bool is_on = shown_ == render::ColorMode::kWireframe;
  if (!is_on) filled_ = shown_;
  shown_ = is_on ? filled_ : render::ColorMode::kWireframe;
}

}  // namespace lode::app
