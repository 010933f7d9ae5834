#pragma once

#include <cstdint>
#include <optional>

namespace lode::render {

/// Estimated exponent k: a frame's work is proportional to 1 / threshold^k. The true exponent lies between 1
/// and 2, depending on how flat the model is.
constexpr double kFallOfWork = 1.5;

/// Mean of the thresholds of parts. The frame would take the same work if all parts had this mean as their
/// threshold (see kFallOfWork).
class MeanThreshold {
 public:
  void add(uint64_t triangles, double threshold_px) noexcept;
  MeanThreshold& operator+=(const MeanThreshold& more) noexcept;
  /// Returns the mean, or 0 if no part was added.
  double px() const noexcept;

 private:
  double triangles_ = 0;
  double triangles_at_1px_ = 0;  ///< estimated number of triangles at a threshold of one pixel
};

/// Mean thresholds of the parts in a picture.
struct ShownThresholds {
  /// Mean in which each part coarser than the cut's threshold counts with the cut's threshold.
  MeanThreshold drawn;
  /// Mean in which each part coarser than the cut's threshold counts with its own error.
  MeanThreshold complete;

  ShownThresholds& operator+=(const ShownThresholds& more) noexcept;
};

/// Ratio of the thresholds in a frame to the finest requested threshold; at least 1.
struct Coarsening {
  double drawn = 1, complete = 1;  ///< ratios of the means of ShownThresholds
  double pixel_share = 0;          ///< share of the frame's work that depends on pixels instead of triangles
  double scale = 1;                ///< scale of the picture's width and height
};

/// Returns the coarsening of a frame. Returns nothing if the frame shows no part.
std::optional<Coarsening> coarseningOf(const ShownThresholds& shown, float finest_px) noexcept;

/// Estimates the share of a frame's work that its pixels cause, if the CPU renders the frame.
double pixelShareInSoftware(uint64_t triangles, double pixels) noexcept;

/// Statistics of one picture.
struct DrawCounts {
  /// Triangles drawn after culling. OcclusionCulling::kOnGpu counts the triangles of a frame a few frames
  /// ago.
  uint64_t triangles = 0;
  uint32_t nodes = 0;
  uint32_t calls = 0;
  float error_px = 0;  ///< largest projected error in the picture, in the view of the cut
  ShownThresholds shown;

  DrawCounts& operator+=(const DrawCounts& more) noexcept;
};

}  // namespace lode::render
