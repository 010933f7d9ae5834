#pragma once

#include <cstdint>
#include <optional>

namespace lode::render {

/// Estimated exponent k: the work of a frame is proportional to 1 / threshold^k, where `threshold` is the
/// error threshold of its parts. The true exponent lies between 1 and 2, depending on how flat the model is.
constexpr double kFallOfWork = 1.5;

/// Mean error threshold of a frame's parts (core::CutPart::threshold_px), weighted by work: a frame in which
/// every part has the mean as its threshold takes the same work (see kFallOfWork).
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

/// Two mean thresholds of the parts in a picture. They differ if the picture shows coarse stand-ins: parts
/// whose error exceeds the cut's threshold, drawn in place of missing meshes.
struct ShownThresholds {
  /// Mean of all drawn parts. A coarse stand-in counts with the cut's threshold.
  MeanThreshold drawn;
  /// Mean of the cut's parts, for estimating the work when all missing meshes have arrived. A coarse stand-in
  /// counts with its own error. Parts that fade out are no longer parts of the cut.
  MeanThreshold complete;

  ShownThresholds& operator+=(const ShownThresholds& more) noexcept;
};

/// Tells how much coarser a frame is than the user requested: the frame rate control raises the error
/// threshold while the camera moves.
struct Coarsening {
  /// The means of ShownThresholds divided by the requested threshold, at least 1.
  double drawn = 1, complete = 1;
  double pixel_share = 0;  ///< share of the frame's work that depends on the number of pixels
  double scale = 1;        ///< width and height of the picture relative to full resolution
};

/// Returns the coarsening of a frame; nothing if the frame shows no part. @param finest_px  the threshold
/// that the user requested.
std::optional<Coarsening> coarseningOf(const ShownThresholds& shown, float finest_px) noexcept;

/// Estimates how much of a frame's work depends on the number of pixels if the CPU renders the frame.
double pixelShareInSoftware(uint64_t triangles, double pixels) noexcept;

/// Statistics of one picture.
struct DrawCounts {
  /// Number of triangles drawn after culling. With OcclusionCulling::kOnGpu, this is the number of a frame
  /// that was drawn a few frames earlier.
  uint64_t triangles = 0;
  uint32_t nodes = 0;
  uint32_t calls = 0;
  /// Largest error of a drawn part in pixels of the picture, projected in the view for which the cut was
  /// made.
  float error_px = 0;
  ShownThresholds shown;

  DrawCounts& operator+=(const DrawCounts& more) noexcept;
};

}  // namespace lode::render
