#pragma once

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

  bool operator==(const Settings&) const = default;
};

constexpr float kLeastExposure = 0.1f, kLargestExposure = 10;
constexpr float kLeastFps = 5, kLargestFps = 240;

}  // namespace lode::app
