#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "client/render/passes/color_mode.h"

namespace lode::app {

/// Settings that the user changes in the window's panel.
struct Settings {
  bool unlit = false;            ///< true shows colours without light
  bool darkens_hollows = true;   ///< true draws ambient occlusion
  bool fades = true;             ///< true cross-fades LODs
  float exposure = 1;            ///< factor on the light, kLeastExposure to kLargestExposure
  bool fixes_threshold = false;  ///< true keeps the threshold even if frames are slow
  /// Threshold while the camera rests, kLeastThresholdPx to kLargestThresholdPx.
  float threshold_px = 1;
  float fps = 60;             ///< frame rate to keep while the camera moves, kLeastFps to kLargestFps
  uint64_t memory_bytes = 0;  ///< budget of streams and GPU copies together

  bool operator==(const Settings&) const = default;
};

constexpr float kLeastExposure = 0.1f, kLargestExposure = 10;
constexpr float kLeastFps = 5, kLargestFps = 240;
/// Memory budgets that the panel offers.
constexpr std::array<uint64_t, 9> kMemorySteps{20'000'000,    50'000'000,    100'000'000,
                                               200'000'000,   500'000'000,   1'000'000'000,
                                               2'000'000'000, 5'000'000'000, 10'000'000'000};
/// Returns the index of the step whose ratio to a budget is closest to 1. Pure.
size_t memoryStepAt(uint64_t bytes) noexcept;

/// The current colour mode. Keys change it.
class ColorModeSwitch {
 public:
  explicit ColorModeSwitch(render::ColorMode first) noexcept
      : shown_(first),
        filled_(first == render::ColorMode::kWireframe ? render::ColorMode::kSurface : first) {}

  render::ColorMode shown() const noexcept { return shown_; }
  /// Steps through all modes and wraps around; negative steps go back.
  void step(int steps) noexcept;
  void show(render::ColorMode shown) noexcept { shown_ = shown; }
  /// Switches to the wireframe; if the wireframe is shown, switches back to the mode before it.
  void toggleWireframe() noexcept;

 private:
  render::ColorMode shown_, filled_;  ///< current mode, and the mode that was shown before the wireframe
};

}  // namespace lode::app
