#include "client/app/window/frame_rate_control.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace lode::app {
namespace {

constexpr double kStepsOfOctave = 4;  ///< number of threshold steps that double the threshold
/// Numbers of threshold steps that halve and double the work. kStepsOfHalving, for raising the threshold,
/// assumes that the work is proportional to 1 / threshold^kFallOfWork. kStepsOfDoubling, for lowering the
/// threshold, cautiously assumes an exponent of 2.
constexpr double kStepsOfHalving = kStepsOfOctave / render::kFallOfWork;
constexpr double kStepsOfDoubling = kStepsOfOctave / 2;
/// Largest number of steps, which raise the threshold 8-fold. If frames need more steps, the frame rate is
/// halved.
constexpr int kMostSteps = 12;
constexpr int kMostHalvings = 3;  ///< largest number of halvings of the rate; 60 frames a second become 7.5
constexpr double kFill = 0.8;     ///< fraction of the target time that a frame should take
/// Fraction of the target time that frames may take after the frame rate is restored. The fraction is below
/// 1, so that the rate does not drop again at once.
constexpr double kFillOfFaster = 0.9;
constexpr double kSpareSteps = 0.25;  ///< margin in steps when the threshold is lowered
constexpr int kSlowFrames = 3;        ///< number of consecutive slow frames after which the rate is halved
/// Number of calm frames in a round of Trials; each restoration needs at least one round.
constexpr int kCalmFrames = 8;
/// Number of frames that a restored rate or resolution must last to count as a success.
constexpr int kTrialFrames = 64;
constexpr int kMorePatience = 4, kMostPatience = 256;  ///< growth factor and limit of Trials::patience_
/// Scales of width and height that leave all, half and a quarter of the pixels.
constexpr std::array kScales{1.0, 0.7071067811865476, 0.5};
/// One step of kScales enlarges the pixels by the same factor as this number of threshold steps.
constexpr int kStepsOfScale = 2;
/// The resolution may drop only if frames need more threshold steps than this, that is, more than twice the
/// user's threshold.
constexpr int kStepsBeforeScale = 4;
/// The resolution drops only if the pixel load (see last_pixel_load_) exceeds this value.
constexpr double kPixelFill = 0.5;
constexpr double kPixelFillAgain = 0.45;  ///< largest pixel load that a restored resolution may cause
constexpr double kNoThreshold = 1000;     ///< stands for a number of steps if no threshold is coarse enough
constexpr double kRestSeconds = 0.25;     ///< time without motion after which the camera is at rest
/// A cut is worth waiting for if its threshold is coarser by the factor kMuchCoarser, and if the last frame
/// exceeded the target time by the factor kMuchSlower.
constexpr double kMuchCoarser = 1.4, kMuchSlower = 2;
constexpr double kShareWaited = 0.5;  ///< longest wait for a cut, relative to the last frame's time
constexpr double kLongestWaitS = 0.25;

double stepsOf(double coarsening) noexcept { return kStepsOfOctave * std::log2(coarsening); }

/// Returns the number of threshold steps that bring a frame's load to 1; negative steps lower the threshold.
/// @param load   time of the frame, divided by the time that it should take.
/// @param share  fraction of the load that is work per pixel, which no threshold reduces.
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

/// Returns the limit of steps_ at the current resolution. The limit falls with the resolution, because larger
/// pixels already make the threshold coarser.
int FrameRateControl::mostSteps() const noexcept {
  return std::max(0, most_steps_ - kStepsOfScale * scale_steps_);
}

int FrameRateControl::wholeSteps(double steps) const noexcept {
  return static_cast<int>(std::clamp(std::ceil(steps), 0.0, static_cast<double>(mostSteps())));
}

void FrameRateControl::step(double seconds, bool moved) noexcept {
  still_s_ = moved ? 0 : still_s_ + seconds;
}

/// Adds a drawn frame. Even a frame that shows coarse stand-ins for missing meshes can prove that the
/// threshold must rise. The threshold may fall only as far as Coarsening::complete allows, which includes the
/// work that the missing meshes will add.
void FrameRateControl::add(double work_ms, const render::Coarsening& coarsening) noexcept {
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

/// Forgets earlier frames after a change of resolution, because their times are not comparable with those of
/// new frames.
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

/// Halves the target frame rate until the fastest of the slow frames would be in time.
void FrameRateControl::lowerRate() noexcept {
  const int halvings = static_cast<int>(std::ceil(std::log2(least_slow_)));
  halvings_ = std::min(halvings_ + std::max(halvings, 1), kMostHalvings);
  slow_frames_ = calm_frames_ = 0;
  rate_.end();
}

/// Restores one step of the frame rate, the resolution or the threshold. Twice the rate means twice the work
/// per second; the next higher resolution means at most twice the work per frame.
void FrameRateControl::ease() noexcept {
  calm_frames_ = 0;
  const bool fits_limit = double_need_ <= mostSteps();
  // True if frames at the higher resolution would need so few steps that the resolution would not drop again.
  const bool stays_fine = full_need_ < kStepsBeforeScale;
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

}  // namespace lode::app
