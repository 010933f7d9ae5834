#include "client/app/window/settings.h"

#include <algorithm>
#include <cmath>

namespace lode::app {

size_t memoryStepAt(uint64_t bytes) noexcept {
  const auto distance = [bytes](uint64_t step) {
    return std::abs(std::log(static_cast<double>(step)) - std::log(static_cast<double>(bytes)));
  };
  return static_cast<size_t>(std::ranges::min_element(kMemorySteps, {}, distance) - kMemorySteps.begin());
}

size_t unitNumber(std::string_view unit) noexcept {
  const auto* const found = std::ranges::find(kUnits, unit);
  return found == kUnits.end() ? 0 : static_cast<size_t>(found - kUnits.begin());
}

void ColorModeSwitch::step(int steps) noexcept {
  const auto count = static_cast<int>(render::colorModes().size());
  shown_ = static_cast<render::ColorMode>((static_cast<int>(shown_) + steps % count + count) % count);
}

void ColorModeSwitch::toggleWireframe() noexcept {
  const bool is_on = shown_ == render::ColorMode::kWireframe;
  if (!is_on) filled_ = shown_;
  shown_ = is_on ? filled_ : render::ColorMode::kWireframe;
}

void ColorModeSwitch::nextClay() noexcept {
  using enum render::ColorMode;
  shown_ = shown_ == kClay ? kMatcap : shown_ == kMatcap ? kSurface : kClay;
}

}  // namespace lode::app
