#pragma once

#include "client/render/shown_colours.h"

namespace lode::app {

/// What is shown of a model, as keys change it.
class ShowSwitch {
 public:
  explicit ShowSwitch(render::Show first) noexcept
      : shown_(first), filled_(first == render::Show::kWireframe ? render::Show::kSurface : first) {}

  render::Show shown() const noexcept { return shown_; }
  /// @param steps  among all that there is, round and round; negative for back.
  void step(int steps) noexcept;
  void show(render::Show shown) noexcept { shown_ = shown; }
  /// A wireframe, or back to what was shown before it.
  void toggleWireframe() noexcept;

 private:
  render::Show shown_, filled_;
};

}  // namespace lode::app
