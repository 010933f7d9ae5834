#pragma once

#include "client/render/shown_colours.h"

namespace lode::app {

/// What is shown of a model, as keys change it.
class ColorModeSwitch {
 public:
  explicit ColorModeSwitch(render::ColorMode first) noexcept
      : shown_(first),
        filled_(first == render::ColorMode::kWireframe ? render::ColorMode::kSurface : first) {}

  render::ColorMode shown() const noexcept { return shown_; }
  /// @param steps  among all that there is, round and round; negative for back.
  void step(int steps) noexcept;
  void show(render::ColorMode shown) noexcept { shown_ = shown; }
  /// A wireframe, or back to what was shown before it.
  void toggleWireframe() noexcept;

 private:
  render::ColorMode shown_, filled_;
};

}  // namespace lode::app
