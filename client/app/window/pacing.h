#pragma once

#include <chrono>
#include <optional>

#include "client/app/window/frame_rate_control.h"
#include "client/render/draw_counts.h"

namespace lode::app {

/// Limits of the window's threshold. Neither keys nor the frame-rate control exceed them.
constexpr float kLeastThresholdPx = 0.1f, kLargestThresholdPx = 64;
constexpr float kThresholdStep = 1.189207115f;  ///< factor of one step, 2^1/4

/// Chooses the threshold and resolution of the next picture. While the camera rests, the threshold is the
/// user's. While the camera moves, a coarser threshold keeps the frame rate. Pure: no clock, no GL.
class Pacing {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;
  struct Options {
    float threshold_px = 1;
    bool is_fixed = false;  ///< true keeps the user's threshold even if frames are slow
    double fps = 60;
    FrameRateControl::Begin begin = FrameRateControl::Begin::kFine;
  };

  Pacing(const Options& options, TimePoint now) noexcept;

  /// Makes the user's threshold finer by `steps` times kThresholdStep; negative steps make it coarser.
  void sharpen(int steps) noexcept;
  void setThreshold(float threshold_px) noexcept;
  /// Sets Options::is_fixed.
  void fix(bool is_fixed) noexcept { is_fixed_ = is_fixed; }
  void setRate(double fps) noexcept;
  /// Reports the time of an earlier frame. @param coarsening  empty if the frame drew nothing.
  void measure(double work_ms, const std::optional<render::Coarsening>& coarsening) noexcept;
  /// Advances time before the next frame.
  void step(double seconds, bool moved, TimePoint now) noexcept;
  /// Reports that a frame was drawn.
  void draw(const std::optional<render::Coarsening>& coarsening, TimePoint now) noexcept;

  bool isFixed() const noexcept { return is_fixed_; }
  double fps() const noexcept { return fps_; }                  ///< frame rate to keep
  float thresholdPx() const noexcept { return threshold_px_; }  ///< threshold while the camera rests
  float askedPx() const noexcept { return asked_px_; }          ///< threshold of the next cut
  /// Returns the factor for the sides of the next picture. Thresholds are in pixels of this picture.
  double scale() const noexcept { return is_fixed_ ? 1 : control_.scale(); }
  /// Returns true if the next picture has the user's threshold and full resolution.
  bool asksForFinest() const noexcept { return asked_px_ <= threshold_px_ && scale() == 1; }
  double workMs() const noexcept { return work_ms_; }  ///< time of the last measured frame
  bool isResting() const noexcept { return control_.isResting(); }
  /// Returns the time that a frame may take; 0 if the threshold is fixed.
  double targetMs() const noexcept { return is_fixed_ ? 0 : control_.targetMs(); }
  /// Returns true if drawing should wait for a much coarser cut, which is faster to draw.
  /// @param drawn_px     threshold of the cut that would be drawn, in the next picture's pixels
  /// @param is_uploaded  true if nothing is left to upload
  bool isWorthWaiting(float drawn_px, bool is_uploaded, TimePoint now) const noexcept;

 private:
  bool is_fixed_;
  double fps_;
  float threshold_px_, asked_px_;
  FrameRateControl control_;
  double work_ms_ = 0;
  double drawn_coarsening_ = 1;
  TimePoint drawn_, began_to_move_;
};

}  // namespace lode::app
