#include "client/render/frame_rate_control.h"

#include <algorithm>
#include <cmath>

namespace lode::render {
namespace {

constexpr double kStepsOfOctave = 4;
/// By the mean of the powers it becomes coarser, and by two finer, so that it is not too fine at once.
constexpr double kStepsOfHalving = kStepsOfOctave / kFallOfWork;
constexpr double kStepsOfDoubling = kStepsOfOctave / 2;
constexpr int kMostSteps = 12;         ///< an eightfold threshold: beyond it a lower rate is the lesser evil
constexpr int kMostHalvings = 3;       ///< 60 frames a second become 7.5
constexpr double kFill = 0.8;          ///< of the target: what is aimed at
constexpr double kFillOfFaster = 0.9;  ///< of a higher rate's: less than what would lower it again
constexpr double kSpareSteps = 0.25;   ///< that a finer threshold leaves
constexpr int kSlowFrames = 3;         ///< before the rate is halved
constexpr int kCalmFrames = 8;         ///< a round of them comes before anything becomes finer or faster
constexpr int kTrialFrames = 64;       ///< that a rate has to last that was given back
constexpr int kMorePatience = 4, kMostPatience = 256;  ///< of rounds, where it does not
constexpr double kRestSeconds = 0.25;
constexpr double kMuchCoarser = 1.4, kMuchSlower = 2;  ///< what is worth waiting for,
constexpr double kShareWaited = 0.5;                   ///< so much of a frame
constexpr double kLongestWaitS = 0.25;

double stepsOf(double coarsening) noexcept { return kStepsOfOctave * std::log2(coarsening); }

double stepsFor(double load) noexcept {
  return (load > 1 ? kStepsOfHalving : kStepsOfDoubling) * std::log2(load);
}

}  // namespace

FrameRateControl::FrameRateControl(double fps, Begin begin) noexcept
    : wanted_ms_(1000 / fps), most_steps_(kMostSteps), steps_(begin == Begin::kCoarse ? kMostSteps : 0) {}

void FrameRateControl::setRate(double fps) noexcept {
  wanted_ms_ = 1000 / fps;
  halvings_ = slow_frames_ = calm_frames_ = 0;
}

void FrameRateControl::limitTo(double coarsening) noexcept {
  most_steps_ = std::clamp(static_cast<int>(stepsOf(coarsening)), 0, kMostSteps);
  steps_ = std::min(steps_, most_steps_);
}

int FrameRateControl::wholeSteps(double steps) const noexcept {
  return static_cast<int>(std::clamp(std::ceil(steps), 0.0, static_cast<double>(most_steps_)));
}

void FrameRateControl::step(double seconds, bool moved) noexcept {
  still_s_ = moved ? 0 : still_s_ + seconds;
}

/// A frame that lacks something says that a coarser threshold is needed, but seldom that a finer one is
/// enough.
void FrameRateControl::add(double work_ms, const Coarsening& coarsening) noexcept {
  const double steps = stepsOf(coarsening.drawn), complete_steps = stepsOf(coarsening.complete);
  const double of_target = std::max(work_ms, 1e-3) / targetMs();
  const double need = steps + stepsFor(of_target / kFill);
  const double complete_need = complete_steps + stepsFor(of_target / kFill);
  const double sure_need = std::min(need, last_need_);
  last_need_ = need;
  trial_frames_ = std::max(trial_frames_ - 1, 0);
  const bool is_slow = std::lround(steps) >= most_steps_ && of_target > 1;
  slow_frames_ = is_slow ? slow_frames_ + 1 : 0;
  if (slow_frames_ >= kSlowFrames && halvings_ < kMostHalvings) {
    halveRate();
  } else if (sure_need > steps_) {
    calm_frames_ = 0;
    steps_ = wholeSteps(sure_need);
  } else if (need > steps_) {
    calm_frames_ = 0;
  } else if (complete_need <= steps_) {
    const double faster_need = complete_steps + stepsFor(2 * of_target / kFillOfFaster);
    const bool is_first = calm_frames_++ == 0;
    calm_need_ = is_first ? complete_need : std::max(calm_need_, complete_need);
    faster_need_ = is_first ? faster_need : std::max(faster_need_, faster_need);
    if (calm_frames_ >= kCalmFrames) ease();
  }
}

void FrameRateControl::halveRate() noexcept {
  ++halvings_;
  slow_frames_ = calm_frames_ = fast_rounds_ = 0;
  patience_ = trial_frames_ > 0 ? std::min(kMorePatience * patience_, kMostPatience) : 1;
  trial_frames_ = 0;
}

void FrameRateControl::ease() noexcept {
  calm_frames_ = 0;
  const bool is_fast = halvings_ > 0 && faster_need_ <= most_steps_;
  fast_rounds_ = is_fast ? fast_rounds_ + 1 : 0;
  if (fast_rounds_ >= patience_) {
    --halvings_;
    fast_rounds_ = 0;
    trial_frames_ = kTrialFrames;
    steps_ = wholeSteps(faster_need_ + kSpareSteps);
  } else {
    steps_ = std::min(steps_, wholeSteps(calm_need_ + kSpareSteps));
  }
}

bool FrameRateControl::isResting() const noexcept { return still_s_ >= kRestSeconds; }

double FrameRateControl::coarsening() const noexcept {
  return isResting() ? 1 : std::exp2(steps_ / kStepsOfOctave);
}

bool FrameRateControl::isWorthWaiting(double coarsening, double work_ms, double waited_s) const noexcept {
  const bool is_much_coarser = this->coarsening() >= kMuchCoarser * coarsening;
  const double worth_s = std::min(kShareWaited * work_ms / 1000, kLongestWaitS);
  return is_much_coarser && work_ms > kMuchSlower * targetMs() && waited_s < worth_s;
}

double FrameRateControl::targetMs() const noexcept { return wanted_ms_ * std::exp2(halvings_); }

}  // namespace lode::render
