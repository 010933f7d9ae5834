#pragma once

#include <cstdint>
#include <optional>

namespace lode::render {

/// Estimate of the exponent by which a frame's work falls as its threshold grows. The true exponent is
/// between 1 and 2, depending on how flat the model is.
constexpr double kFallOfWork = 1.5;

/// Mean of the thresholds of parts. If all parts had the mean as their threshold, the frame's work would be
/// the same (see kFallOfWork).
class MeanThreshold {
 public:
  void add(uint64_t triangles, double threshold_px) noexcept;
  MeanThreshold& operator+=(const MeanThreshold& more) noexcept;
  /// Returns the mean, or 0 if no part was added.
  double px() const noexcept;

 private:
  double triangles_ = 0;
  double triangles_at_1px_ = 0;  ///< estimated triangles at a threshold of one pixel
};

/// Mean thresholds of the parts in a picture.
struct ShownThresholds {
  MeanThreshold drawn;     ///< mean that counts a part coarser than the cut's threshold as meeting it
  MeanThreshold complete;  ///< mean that counts such a part with its own error

  ShownThresholds& operator+=(const ShownThresholds& more) noexcept;
};

/// Ratio of the thresholds shown to the finest threshold requested, >= 1.
struct Coarsening {
  double drawn = 1, complete = 1;  ///< ratios of the means of ShownThresholds
  double pixel_share = 0;          ///< share of the frame's work that depends on pixels instead of triangles
  double scale = 1;                ///< factor on the resolution of each side
};

/// Returns the coarsening of a frame, or nothing if the frame shows no part and so says nothing about work.
std::optional<Coarsening> coarseningOf(const ShownThresholds& shown, float finest_px) noexcept;

/// Estimates the share of a frame's work that its pixels cause when the CPU renders it.
double pixelShareInSoftware(uint64_t triangles, double pixels) noexcept;

/// Statistics of one picture.
struct DrawCounts {
  /// Triangles drawn after culling. OcclusionCulling::kOnGpu counts the triangles of a frame a few frames
  /// ago.
  uint64_t triangles = 0;
  uint32_t nodes = 0;
  uint32_t calls = 0;
  float error_px = 0;  ///< largest projected error in the picture, for the view that the cut was made for
  ShownThresholds shown;

  DrawCounts& operator+=(const DrawCounts& more) noexcept;
};

}  // namespace lode::render
