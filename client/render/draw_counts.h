#pragma once

#include <cstdint>
#include <optional>

namespace lode::render {

/// The work of a frame falls with this power of its threshold: 1 to 2, depending on how flat the model is.
constexpr double kFallOfWork = 1.5;

/// Mean of part thresholds, weighted so that one threshold for all parts would take the same work (see
/// kFallOfWork).
class MeanThreshold {
 public:
  void add(uint64_t triangles, double threshold_px) noexcept;
  MeanThreshold& operator+=(const MeanThreshold& more) noexcept;
  /// 0 if no part was added.
  double px() const noexcept;

 private:
  double triangles_ = 0;
  double triangles_at_1px_ = 0;  ///< estimated triangles at a threshold of one pixel
};

/// Mean thresholds of the parts in a picture.
struct ShownThresholds {
  MeanThreshold drawn;     ///< parts coarser than the cut's threshold count as if they met it
  MeanThreshold complete;  ///< such parts count with their own error

  ShownThresholds& operator+=(const ShownThresholds& more) noexcept;
};

/// Ratio of the thresholds shown to the finest threshold requested, >= 1.
struct Coarsening {
  double drawn = 1, complete = 1;  ///< see ShownThresholds
  double pixel_share = 0;          ///< share of the frame's work that grows with pixels, not triangles
  double scale = 1;                ///< resolution scale per side
};

/// Returns nothing if no part is shown: such a frame says nothing about work.
std::optional<Coarsening> coarseningOf(const ShownThresholds& shown, float finest_px) noexcept;

/// Estimates the share of a frame's work that its pixels cause when the CPU renders it.
double pixelShareInSoftware(uint64_t triangles, double pixels) noexcept;

/// Statistics of one picture.
struct DrawCounts {
  /// Triangles drawn after culling. With OcclusionCulling::kOnGpu: of a frame a few frames ago.
  uint64_t triangles = 0;
  uint32_t nodes = 0;
  uint32_t calls = 0;
  float error_px = 0;  ///< largest error in the picture, as projected when the cut was made
  ShownThresholds shown;

  DrawCounts& operator+=(const DrawCounts& more) noexcept;
};

}  // namespace lode::render
