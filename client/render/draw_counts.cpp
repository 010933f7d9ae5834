#include "client/render/draw_counts.h"

#include <algorithm>
#include <cmath>

namespace lode::render {

void MeanThreshold::add(uint64_t triangles, double threshold_px) noexcept {
  triangles_ += static_cast<double>(triangles);
  triangles_at_1px_ += static_cast<double>(triangles) * std::pow(threshold_px, kFallOfWork);
}

MeanThreshold& MeanThreshold::operator+=(const MeanThreshold& more) noexcept {
  triangles_ += more.triangles_;
  triangles_at_1px_ += more.triangles_at_1px_;
  return *this;
}

double MeanThreshold::px() const noexcept {
  return triangles_ > 0 ? std::pow(triangles_at_1px_ / triangles_, 1 / kFallOfWork) : 0;
}

ShownThresholds& ShownThresholds::operator+=(const ShownThresholds& more) noexcept {
  drawn += more.drawn;
  complete += more.complete;
  return *this;
}

std::optional<Coarsening> coarseningOf(const ShownThresholds& shown, float finest_px) noexcept {
  if (shown.drawn.px() == 0 && shown.complete.px() == 0) return std::nullopt;
  return Coarsening{std::max(1.0, shown.drawn.px() / finest_px),
                    std::max(1.0, shown.complete.px() / finest_px)};
}

double pixelShareInSoftware(uint64_t triangles, double pixels) noexcept {
  // Number of pixels that cost as much as one triangle in Mesa's llvmpipe.
  constexpr double kPixelsOfTriangle = 11;
  return pixels / (pixels + kPixelsOfTriangle * static_cast<double>(triangles));
}

DrawCounts& DrawCounts::operator+=(const DrawCounts& more) noexcept {
  triangles += more.triangles;
  nodes += more.nodes;
  calls += more.calls;
  error_px = std::max(error_px, more.error_px);
  shown += more.shown;
  return *this;
}

}  // namespace lode::render
