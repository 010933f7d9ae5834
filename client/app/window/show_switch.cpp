#include "client/app/window/show_switch.h"

namespace lode::app {

void ShowSwitch::step(int steps) noexcept {
  const int next = static_cast<int>(shown_) + steps % render::kShowCount + render::kShowCount;
  shown_ = static_cast<render::Show>(next % render::kShowCount);
}

void ShowSwitch::toggleWireframe() noexcept {
  const bool is_on = shown_ == render::Show::kWireframe;
  if (!is_on) filled_ = shown_;
  shown_ = is_on ? filled_ : render::Show::kWireframe;
}

}  // namespace lode::app
