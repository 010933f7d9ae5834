#include "client/app/window/pacing.h"

#include <algorithm>
#include <cmath>

namespace lode::app {

Pacing::Pacing(const Options& options, TimePoint now) noexcept
    : is_fixed_(options.is_fixed),
      fps_(options.fps),
      threshold_px_(options.threshold_px),
      asked_px_(options.threshold_px),
      control_(options.fps, options.begin),
      drawn_(now),
      began_to_move_(now) {
  control_.limitTo(kLargestThresholdPx / threshold_px_);
}

void Pacing::sharpen(int steps) noexcept {
  if (steps == 0) return;
  setThreshold(threshold_px_ * std::pow(kThresholdStep, static_cast<float>(-steps)));
}

void Pacing::setThreshold(float threshold_px) noexcept {
  threshold_px_ = std::clamp(threshold_px, kLeastThresholdPx, kLargestThresholdPx);
  control_.limitTo(kLargestThresholdPx / threshold_px_);
}

void Pacing::setRate(double fps) noexcept {
  fps_ = fps;
  control_.setRate(fps);
}

void Pacing::measure(double work_ms, const std::optional<render::Coarsening>& coarsening) noexcept {
  work_ms_ = work_ms;
  if (!is_fixed_ && coarsening) control_.add(work_ms, *coarsening);
}

void Pacing::step(double seconds, bool moved, TimePoint now) noexcept {
  if (moved && control_.isResting()) began_to_move_ = now;
  control_.step(seconds, moved);
  is_moving_ = (is_moving_ || moved) && !control_.isResting();
  asked_px_ = threshold_px_ * static_cast<float>(is_fixed_ ? 1 : control_.coarsening());
}

void Pacing::draw(const std::optional<render::Coarsening>& coarsening, TimePoint now) noexcept {
  drawn_coarsening_ = coarsening ? coarsening->drawn / coarsening->scale : 1;
  drawn_ = now;
}

bool Pacing::isWorthWaiting(float drawn_px, bool is_uploaded, TimePoint now) const noexcept {
  const bool is_drawable = is_uploaded && kThresholdStep * drawn_px >= asked_px_;
  if (is_fixed_ || is_drawable) return false;
  const std::chrono::duration<double> waited = now - std::max(drawn_, began_to_move_);
  return control_.isWorthWaiting(drawn_coarsening_, work_ms_, waited.count());
}

}  // namespace lode::app
