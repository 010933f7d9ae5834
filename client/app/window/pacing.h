#pragma once

#include <chrono>
#include <optional>

#include "client/app/window/frame_rate_control.h"
#include "client/render/shown_thresholds.h"

namespace lode::app {

/// Between which a window's threshold is, whatever keys and the frame rate ask for.
constexpr float kLeastThresholdPx = 0.1f, kLargestThresholdPx = 64;
constexpr float kThresholdStep = 1.189207115f;  ///< 2^1/4

/// How fine the window's next picture is to be: the user's threshold while the camera rests, what the frame
/// rate allows while it moves; and whether it is worth waiting for. Pure: no clock, no GL.
class Pacing {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;
  struct Options {
    float threshold_px = 1;
    bool is_fixed = false;  ///< the threshold is the user's whatever a frame takes
    double fps = 60;
    render::FrameRateControl::Begin begin = render::FrameRateControl::Begin::kFine;
  };

  Pacing(const Options& options, TimePoint now) noexcept;

  /// So many steps of the user's threshold; coarser below 0.
  void sharpen(int steps) noexcept;
  void setThreshold(float threshold_px) noexcept;
  /// Whether it is the user's whatever a frame takes.
  void fix(bool is_fixed) noexcept { is_fixed_ = is_fixed; }
  void setRate(double fps) noexcept;
  /// What a frame took that was drawn some frames ago. @param coarsening  nothing if it showed nothing
  void measure(double work_ms, const std::optional<render::Coarsening>& coarsening) noexcept;
  /// Time passes before the next frame.
  void step(double seconds, bool moved, TimePoint now) noexcept;
  /// A frame was drawn.
  void draw(const std::optional<render::Coarsening>& coarsening, TimePoint now) noexcept;

  bool isFixed() const noexcept { return is_fixed_; }
  double fps() const noexcept { return fps_; }                  ///< that are wanted
  float thresholdPx() const noexcept { return threshold_px_; }  ///< while the camera rests
  float askedPx() const noexcept { return asked_px_; }          ///< of the next cut
  /// Of the sides of the next picture; thresholds are in its pixels.
  double scale() const noexcept { return is_fixed_ ? 1 : control_.scale(); }
  /// And for nothing coarser.
  bool asksForFinest() const noexcept { return asked_px_ <= threshold_px_ && scale() == 1; }
  double workMs() const noexcept { return work_ms_; }  ///< of the last frame that was measured
  bool isResting() const noexcept { return control_.isResting(); }
  /// What a frame may take; 0 where that has no say.
  double targetMs() const noexcept { return is_fixed_ ? 0 : control_.targetMs(); }
  /// Whether to draw nothing for now, but wait for all of a much coarser cut.
  /// @param drawn_px     of what would be drawn, in the next picture's pixels
  /// @param is_uploaded  there is nothing to wait for
  bool isWorthWaiting(float drawn_px, bool is_uploaded, TimePoint now) const noexcept;

 private:
  bool is_fixed_;
  double fps_;
  float threshold_px_, asked_px_;
  render::FrameRateControl control_;
  double work_ms_ = 0;
  double drawn_coarsening_ = 1;
  TimePoint drawn_, began_to_move_;
};

}  // namespace lode::app
