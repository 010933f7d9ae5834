#pragma once

#include <chrono>
#include <optional>

#include "client/app/window/frame_rate_control.h"
#include "client/render/draw_counts.h"

namespace lode::app {

/// Range of the window's error threshold. Neither keys nor the frame-rate control can leave this range.
constexpr float kLeastThresholdPx = 0.1f, kLargestThresholdPx = 64;
constexpr float kThresholdStep = 1.189207115f;  ///< ratio of neighbouring threshold steps, 2^(1/4)

/// Chooses the error threshold and the resolution of the next picture. While the camera is at rest, the
/// user's threshold applies. While the camera moves, the threshold is raised to hold the frame rate: see
/// FrameRateControl. Pure: no clock, no GL.
class Pacing {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;
  struct Options {
    float threshold_px = 1;
    bool is_fixed = false;  ///< true to keep the user's threshold even if frames are slow
    double fps = 60;
    FrameRateControl::Begin begin = FrameRateControl::Begin::kFine;
  };

  Pacing(const Options& options, TimePoint now) noexcept;

  /// Divides the user's threshold by kThresholdStep^steps. Negative steps raise the threshold.
  void sharpen(int steps) noexcept;
  void setThreshold(float threshold_px) noexcept;
  /// Sets Options::is_fixed.
  void fix(bool is_fixed) noexcept { is_fixed_ = is_fixed; }
  void setRate(double fps) noexcept;
  /// Reports the time of an earlier frame. @param coarsening  empty if the frame drew nothing or is not
  /// typical of a moving camera.
  void measure(double work_ms, const std::optional<render::Coarsening>& coarsening) noexcept;
  /// Advances time before the next frame. @param moved  true if the camera moved since the last frame.
  void step(double seconds, bool moved, TimePoint now) noexcept;
  /// Reports that a frame was drawn.
  void draw(const std::optional<render::Coarsening>& coarsening, TimePoint now) noexcept;

  bool isFixed() const noexcept { return is_fixed_; }
  double fps() const noexcept { return fps_; }                  ///< frame rate to hold
  float thresholdPx() const noexcept { return threshold_px_; }  ///< the user's threshold
  float askedPx() const noexcept { return asked_px_; }          ///< threshold to request for the next cut
  /// Returns the scale of the next picture's width and height. Thresholds are in pixels of the scaled
  /// picture.
  double scale() const noexcept { return is_fixed_ ? 1 : control_.scale(); }
  /// Returns true if the next picture has the user's threshold and full resolution.
  bool asksForFinest() const noexcept { return asked_px_ <= threshold_px_ && scale() == 1; }
  double workMs() const noexcept { return work_ms_; }  ///< time of the last measured frame
  bool isResting() const noexcept { return control_.isResting(); }
  /// Returns true from the camera's motion until it rests. Unlike isResting(), it does not count the coarse
  /// first pictures of a camera that has not moved.
  bool isMoving() const noexcept { return is_moving_; }
  /// Returns the time that a frame may take; 0 if the threshold is fixed.
  double targetMs() const noexcept { return is_fixed_ ? 0 : control_.targetMs(); }
  /// Returns true if drawing should wait, because a much coarser cut, which is faster to draw, will arrive
  /// soon.
  /// @param drawn_px     threshold of the cut that would be drawn now, in pixels of the next picture
  /// @param is_uploaded  true if the newest cut is completely uploaded
  bool isWorthWaiting(float drawn_px, bool is_uploaded, TimePoint now) const noexcept;

 private:
  bool is_fixed_;
  double fps_;
  float threshold_px_, asked_px_;
  FrameRateControl control_;
  double work_ms_ = 0;
  double drawn_coarsening_ = 1;
  TimePoint drawn_, began_to_move_;
  bool is_moving_ = false;
};

}  // namespace lode::app
