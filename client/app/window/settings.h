#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "client/render/passes/color_mode.h"

namespace lode::app {

/// Settings that the user changes in the window's panel.
struct Settings {
  bool unlit = false;           ///< true to show colours without lighting
  bool darkens_hollows = true;  ///< true to draw ambient occlusion
  bool fades = true;            ///< true to cross-fade LODs
  float exposure = 1;           ///< factor that multiplies the light, from kLeastExposure to kLargestExposure
  bool fixes_threshold = false;  ///< true to keep the threshold even if frames are slow
  /// Error threshold for a camera at rest, from kLeastThresholdPx to kLargestThresholdPx.
  float threshold_px = 1;
  float fps = 60;             ///< frame rate to hold while the camera moves, from kLeastFps to kLargestFps
  uint64_t memory_bytes = 0;  ///< total memory budget of the streams and the GPU

  bool operator==(const Settings&) const = default;
};

constexpr float kLeastExposure = 0.1f, kLargestExposure = 10;
constexpr float kLeastFps = 5, kLargestFps = 240;
/// Memory budgets that the panel offers.
constexpr std::array<uint64_t, 9> kMemorySteps{20'000'000,    50'000'000,    100'000'000,
                                               200'000'000,   500'000'000,   1'000'000'000,
                                               2'000'000'000, 5'000'000'000, 10'000'000'000};
/// Returns the index of the memory step nearest to a budget on a logarithmic scale. Pure.
size_t memoryStepAt(uint64_t bytes) noexcept;

/// The current colour mode. Keys switch between the modes.
class ColorModeSwitch {
 public:
  explicit ColorModeSwitch(render::ColorMode first) noexcept
      : shown_(first),
        filled_(first == render::ColorMode::kWireframe ? render::ColorMode::kSurface : first) {}

  render::ColorMode shown() const noexcept { return shown_; }
  /// Steps through all modes and wraps around; negative steps go back.
  void step(int steps) noexcept;
  void show(render::ColorMode shown) noexcept { shown_ = shown; }
  /// Switches between the wireframe and the mode that was shown before the wireframe.
  void toggleWireframe() noexcept;

 private:
  render::ColorMode shown_, filled_;  ///< current mode, and the mode that was shown before the wireframe
};

}  // namespace lode::app
