#pragma once

#include <cstdint>
#include <optional>

namespace lode::render {

/// What a frame takes falls with this power of its threshold: by one on flat models, by two at most.
constexpr double kFallOfWork = 1.5;

/// The threshold of parts that would take as much as those of several, by that power.
class MeanThreshold {
 public:
  void add(uint64_t triangles, double threshold_px) noexcept;
  MeanThreshold& operator+=(const MeanThreshold& more) noexcept;
  /// 0: of no parts.
  double px() const noexcept;

 private:
  double triangles_ = 0, coarse_triangles_ = 0;  ///< that there would be at a threshold of one pixel
};

/// Thresholds of what a picture shows.
struct ShownThresholds {
  MeanThreshold drawn;     ///< of its parts, what stands in for something finer counted as that
  MeanThreshold complete;  ///< coarser, if what stands in has yet to become what its threshold asks for

  ShownThresholds& operator+=(const ShownThresholds& more) noexcept;
};

/// The same by how much coarser they are than the finest threshold that is asked for, >= 1.
struct Coarsening {
  double drawn = 1, complete = 1;
  double pixel_share = 0;  ///< of what the picture takes, by its pixels and not by its triangles
  double scale = 1;        ///< of its sides
};

/// Nothing where nothing is shown: it tells nothing of what a frame takes.
std::optional<Coarsening> coarseningOf(const ShownThresholds& shown, float finest_px) noexcept;

/// Of what a picture takes where the processor draws it: about that of a model's pixels and triangles.
double pixelShareInSoftware(uint64_t triangles, double pixels) noexcept;

}  // namespace lode::render
