#include "client/app/window/frame_rate_control.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace lode::render {
namespace {

constexpr double kStepsOfOctave = 4;
/// Steps that halve the work when the threshold gets coarser, and that double it when the threshold gets
/// finer. The first assumes the usual power law of work over threshold, the second, to be careful, the
/// square.
constexpr double kStepsOfHalving = kStepsOfOctave / kFallOfWork;
constexpr double kStepsOfDoubling = kStepsOfOctave / 2;
constexpr int kMostSteps = 12;    ///< 8 times the threshold; if frames need more steps, the rate is halved
constexpr int kMostHalvings = 3;  ///< 60 frames a second become 7.5
constexpr double kFill = 0.8;     ///< part of the target time that frames aim at
/// Part of the target time that frames may take after the rate is restored; below 1, or the rate would drop
/// again.
constexpr double kFillOfFaster = 0.9;
constexpr double kSpareSteps = 0.25;  ///< margin when the threshold becomes finer
constexpr int kSlowFrames = 3;        ///< consecutive slow frames that halve the rate
constexpr int kCalmFrames = 8;        ///< frames in a round; restoring anything needs at least one round
constexpr int kTrialFrames = 64;      ///< frames that a restored rate or resolution must last
constexpr int kMorePatience = 4, kMostPatience = 256;        ///< factor and limit of Trials::patience_
constexpr std::array kScales{1.0, 0.7071067811865476, 0.5};  ///< all, half and a quarter of the pixels
constexpr int kStepsOfScale = 2;  ///< threshold steps that equal one step of kScales, in window pixels
/// Twice the threshold; if frames need more steps, the resolution can drop.
constexpr int kStepsBeforeScale = 4;
constexpr double kPixelFill = 0.5;        ///< part of a frame's time that the work per pixel may take
constexpr double kPixelFillAgain = 0.45;  ///< kPixelFill for a restored resolution
constexpr double kNoThreshold = 1000;     ///< number of steps that means: no threshold is coarse enough
constexpr double kRestSeconds = 0.25;
constexpr double kMuchCoarser = 1.4, kMuchSlower = 2;  ///< least factors of a cut worth waiting for
constexpr double kShareWaited = 0.5;                   ///< longest wait, as a share of the last frame's time
constexpr double kLongestWaitS = 0.25;

double stepsOf(double coarsening) noexcept { return kStepsOfOctave * std::log2(coarsening); }

/// Returns the threshold steps that bring a load to 1.
/// @param share  part of the load that is work per pixel, which no threshold reduces.
double stepsFor(double load, double share) noexcept {
  const double left = 1 - share * load, triangles = (1 - share) * load;
  if (left <= 0) return kNoThreshold;
  const double steps = (load > 1 ? kStepsOfHalving : kStepsOfDoubling) * std::log2(triangles / left);
  return std::clamp(steps, -kNoThreshold, kNoThreshold);
}

}  // namespace

bool Trials::see(bool agrees) noexcept {
  rounds_ = agrees ? rounds_ + 1 : 0;
  return rounds_ >= patience_;
}

void Trials::begin() noexcept {
  rounds_ = 0;
  frames_ = kTrialFrames;
}

void Trials::end() noexcept {
  patience_ = frames_ > 0 ? std::min(kMorePatience * patience_, kMostPatience) : 1;
  rounds_ = frames_ = 0;
}

void Trials::passFrame() noexcept { frames_ = std::max(frames_ - 1, 0); }

FrameRateControl::FrameRateControl(double fps, Begin begin) noexcept
    : wanted_ms_(1000 / fps), most_steps_(kMostSteps), steps_(begin == Begin::kCoarse ? kMostSteps : 0) {}

void FrameRateControl::setRate(double fps) noexcept {
  wanted_ms_ = 1000 / fps;
  halvings_ = slow_frames_ = calm_frames_ = 0;
  rate_ = resolution_ = {};
}

void FrameRateControl::limitTo(double coarsening) noexcept {
  most_steps_ = std::clamp(static_cast<int>(stepsOf(coarsening)), 0, kMostSteps);
  steps_ = std::min(steps_, mostSteps());
}

/// Returns the limit of steps_ in the picture's pixels, which a lower resolution makes larger.
int FrameRateControl::mostSteps() const noexcept {
  return std::max(0, most_steps_ - kStepsOfScale * scale_steps_);
}

int FrameRateControl::wholeSteps(double steps) const noexcept {
  return static_cast<int>(std::clamp(std::ceil(steps), 0.0, static_cast<double>(mostSteps())));
}

void FrameRateControl::step(double seconds, bool moved) noexcept {
  still_s_ = moved ? 0 : still_s_ + seconds;
}

/// Frames with missing parts can show that a coarser threshold is needed. Only the complete parts of a frame
/// can show that a finer threshold fits.
void FrameRateControl::add(double work_ms, const Coarsening& coarsening) noexcept {
  if (coarsening.scale != movingScale()) return;
  const double steps = stepsOf(coarsening.drawn), complete_steps = stepsOf(coarsening.complete);
  const double of_target = std::max(work_ms, 1e-3) / targetMs();
  const double by_pixels = coarsening.pixel_share, pixel_load = by_pixels * of_target / kFill;
  const double need = steps + stepsFor(of_target / kFill, by_pixels);
  const double complete_need = complete_steps + stepsFor(of_target / kFill, by_pixels);
  const double sure_need = std::min(need, last_need_);
  const double sure_pixel_load = std::min(pixel_load, last_pixel_load_);
  last_need_ = need;
  last_pixel_load_ = pixel_load;
  rate_.passFrame();
  resolution_.passFrame();
  const bool is_slow = std::lround(steps) >= mostSteps() && of_target > 1;
  least_slow_ = slow_frames_ > 0 ? std::min(least_slow_, of_target) : of_target;
  slow_frames_ = is_slow ? slow_frames_ + 1 : 0;
  const bool has_scales_left = scale_steps_ + 1 < static_cast<int>(kScales.size());
  if (sure_pixel_load > kPixelFill && sure_need > kStepsBeforeScale && has_scales_left) {
    lowerScale(sure_pixel_load);
  } else if (slow_frames_ >= kSlowFrames && halvings_ < kMostHalvings) {
    lowerRate();
  } else if (sure_need > steps_) {
    calm_frames_ = 0;
    steps_ = wholeSteps(sure_need);
  } else if (need > steps_) {
    calm_frames_ = 0;
  } else if (complete_need <= steps_) {
    const double double_need = complete_steps + stepsFor(2 * of_target / kFillOfFaster, by_pixels);
    const bool is_first = calm_frames_++ == 0;
    calm_need_ = is_first ? complete_need : std::max(calm_need_, complete_need);
    calm_pixel_load_ = is_first ? pixel_load : std::max(calm_pixel_load_, pixel_load);
    double_need_ = is_first ? double_need : std::max(double_need_, double_need);
    const double full_need = complete_steps + stepsFor(2 * of_target / kFill, by_pixels);
    full_need_ = is_first ? full_need : std::max(full_need_, full_need);
    if (calm_frames_ >= kCalmFrames) ease();
  }
}

/// Forgets earlier frames, because frames of the new resolution differ from them in more than the threshold.
void FrameRateControl::forgetFrames() noexcept {
  last_need_ = last_pixel_load_ = 0;
  slow_frames_ = calm_frames_ = 0;
}

void FrameRateControl::lowerScale(double pixel_load) noexcept {
  const int halvings = static_cast<int>(std::ceil(std::log2(pixel_load / kPixelFill)));
  scale_steps_ = std::min(scale_steps_ + std::max(halvings, 1), static_cast<int>(kScales.size()) - 1);
  steps_ = std::min(steps_, mostSteps());
  resolution_.end();
  forgetFrames();
}

/// Halves the rate as often as the fastest of the slow frames needs.
void FrameRateControl::lowerRate() noexcept {
  const int halvings = static_cast<int>(std::ceil(std::log2(least_slow_)));
  halvings_ = std::min(halvings_ + std::max(halvings, 1), kMostHalvings);
  slow_frames_ = calm_frames_ = 0;
  rate_.end();
}

/// Restores the rate, the resolution or the threshold. Twice the rate means twice the work; the next higher
/// resolution means at most twice the work.
void FrameRateControl::ease() noexcept {
  calm_frames_ = 0;
  const bool fits_limit = double_need_ <= mostSteps();
  const bool stays_fine = full_need_ < kStepsBeforeScale;  // otherwise the resolution would drop again
  const bool leaves_room =
      double_need_ <= mostSteps() + kStepsOfScale && 2 * calm_pixel_load_ <= kPixelFillAgain;
  if (rate_.see(halvings_ > 0 && fits_limit)) {
    --halvings_;
    rate_.begin();
    steps_ = wholeSteps(double_need_ + kSpareSteps);
  } else if (resolution_.see(scale_steps_ > 0 && (stays_fine || leaves_room))) {
    --scale_steps_;
    resolution_.begin();
    forgetFrames();
    steps_ = wholeSteps(double_need_ + kSpareSteps);
  } else {
    steps_ = std::min(steps_, wholeSteps(calm_need_ + kSpareSteps));
  }
}

bool FrameRateControl::isResting() const noexcept { return still_s_ >= kRestSeconds; }

double FrameRateControl::coarsening() const noexcept {
  return isResting() ? 1 : std::exp2(steps_ / kStepsOfOctave);
}

double FrameRateControl::movingScale() const noexcept {
  return kScales.at(static_cast<size_t>(scale_steps_));
}

double FrameRateControl::scale() const noexcept { return isResting() ? 1 : movingScale(); }

bool FrameRateControl::isWorthWaiting(double coarsening, double work_ms, double waited_s) const noexcept {
  const bool is_much_coarser = this->coarsening() / scale() >= kMuchCoarser * coarsening;
  const double worth_s = std::min(kShareWaited * work_ms / 1000, kLongestWaitS);
  return is_much_coarser && work_ms > kMuchSlower * targetMs() && waited_s < worth_s;
}

double FrameRateControl::targetMs() const noexcept { return wanted_ms_ * std::exp2(halvings_); }

}  // namespace lode::render
