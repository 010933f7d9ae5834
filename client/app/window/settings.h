#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include <glm/glm.hpp>

#include "client/core/view/framing.h"
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
  bool parallel = false;      ///< true for parallel projection
  std::optional<core::Side> side = std::nullopt;  ///< side to look at, if the user has just chosen one
  size_t background = 0;                          ///< index into kBackgrounds
  size_t cap_colour = 0;                          ///< index into kCapColours (section_plane.h)
  bool shows_scale = true;                        ///< true to draw the scale bar and the axes
  size_t unit = 0;                                ///< index into kUnits: the unit of the model's coordinates

  bool operator==(const Settings&) const = default;
};

constexpr float kLeastExposure = 0.1f, kLargestExposure = 10;
constexpr float kLeastFps = 5, kLargestFps = 240;
/// Memory budgets that the panel offers.
constexpr std::array<uint64_t, 9> kMemorySteps{20'000'000,    50'000'000,    100'000'000,
                                               200'000'000,   500'000'000,   1'000'000'000,
                                               2'000'000'000, 5'000'000'000, 10'000'000'000};
/// A background that the panel offers. Colours are sRGB, 0 to 1.
struct Background {
  std::string_view name;
  glm::vec3 top_srgb, bottom_srgb;
};
constexpr std::array<Background, 5> kBackgrounds{{{"dusk", {0.30f, 0.34f, 0.39f}, {0.10f, 0.11f, 0.13f}},
                                                  {"black", {0, 0, 0}, {0, 0, 0}},
                                                  {"grey", {0.5f, 0.5f, 0.5f}, {0.5f, 0.5f, 0.5f}},
                                                  {"light", {0.93f, 0.94f, 0.96f}, {0.72f, 0.74f, 0.78f}},
                                                  {"white", {1, 1, 1}, {1, 1, 1}}}};
/// Units of length that the panel offers. Files do not name their unit; the first is none.
constexpr std::array<std::string_view, 8> kUnits{"", "um", "mm", "cm", "m", "km", "in", "ft"};
/// Returns the index of a unit in kUnits; 0 if it is none of them. Pure.
size_t unitNumber(std::string_view unit) noexcept;
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
  /// Switches from any mode to clay, from clay to the matcap, and from there to the surface.
  void nextClay() noexcept;

 private:
  render::ColorMode shown_, filled_;  ///< current mode, and the mode that was shown before the wireframe
};

}  // namespace lode::app
