#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace lode::app {

/// What can be set in the window, besides by options and keys.
struct Settings {
  bool unlit = false;            ///< the paint alone
  bool darkens_hollows = true;   ///< ambient occlusion
  bool fades = true;             ///< what arrives and leaves
  float exposure = 1;            ///< kLeastExposure to kLargestExposure
  bool fixes_threshold = false;  ///< whatever a frame takes
  float threshold_px = 1;        ///< of a camera at rest, kLeastThresholdPx to kLargestThresholdPx
  float fps = 60;                ///< while the camera moves, kLeastFps to kLargestFps
  uint64_t memory_bytes = 0;     ///< of streams and on the GPU together

  bool operator==(const Settings&) const = default;
};

constexpr float kLeastExposure = 0.1f, kLargestExposure = 10;
/// That the memory is set to.
constexpr std::array<uint64_t, 9> kMemorySteps{20'000'000,    50'000'000,    100'000'000,
                                               200'000'000,   500'000'000,   1'000'000'000,
                                               2'000'000'000, 5'000'000'000, 10'000'000'000};
/// The one that is nearest to this many bytes, by their ratio. Pure.
size_t memoryStepAt(uint64_t bytes) noexcept;
constexpr float kLeastFps = 5, kLargestFps = 240;

}  // namespace lode::app
