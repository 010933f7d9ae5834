#include "client/render/frame_rate_control.h"

#include <algorithm>
#include <cmath>

namespace lode::render {
namespace {

constexpr double kStepsOfOctave = 4;
/// What a frame takes falls with its threshold's power of one, on flat models, to two.
constexpr double kStepsOfHalving = kStepsOfOctave / 1.5;
constexpr int kMostSteps = 12;       ///< an eightfold threshold: beyond it a lower rate is the lesser evil
constexpr int kMostHalvings = 3;     ///< 60 frames a second become 7.5
constexpr double kFill = 0.8;        ///< of the target: what is aimed at
constexpr double kSlackSteps = 2.5;  ///< the threshold becomes finer where so much is left,
constexpr int kCalmFrames = 8;       ///< in so many frames
constexpr double kRestSeconds = 0.25;

}  // namespace

void FrameRateControl::step(double seconds, bool moved) noexcept {
  still_s_ = moved ? 0 : still_s_ + seconds;
}

void FrameRateControl::add(double work_ms, double coarsening) noexcept {
  const double steps = kStepsOfOctave * std::log2(coarsening);
  const double load = std::max(work_ms, 1e-3) / (kFill * targetMs());
  const double need = steps + kStepsOfHalving * std::log2(load);
  const double sure_need = std::min(need, last_need_);
  last_need_ = need;
  if (sure_need > steps_) {
    calm_frames_ = 0;
    const bool is_coarsest = std::lround(steps) >= kMostSteps;
    if (is_coarsest && work_ms > targetMs()) halvings_ = std::min(halvings_ + 1, kMostHalvings);
    steps_ = static_cast<int>(std::min(std::ceil(sure_need), double{kMostSteps}));
  } else if (need > steps_ - kSlackSteps) {
    calm_frames_ = 0;
  } else if (++calm_frames_ >= kCalmFrames) {
    calm_frames_ = 0;
    const bool is_faster_possible = need + kStepsOfHalving < kMostSteps - kSlackSteps;
    if (halvings_ > 0 && is_faster_possible) {
      --halvings_;
    } else {
      steps_ = std::max(0, steps_ - 1);
    }
  }
}

bool FrameRateControl::isResting() const noexcept { return still_s_ >= kRestSeconds; }

double FrameRateControl::coarsening() const noexcept {
  return isResting() ? 1 : std::exp2(steps_ / kStepsOfOctave);
}

double FrameRateControl::targetMs() const noexcept { return wanted_ms_ * std::exp2(halvings_); }

}  // namespace lode::render
