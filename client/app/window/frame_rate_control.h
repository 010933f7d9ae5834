#pragma once

#include "client/render/draw_counts.h"

namespace lode::app {

/// Hysteresis for a change that may have to be undone, such as a higher resolution. After each failed trial,
/// more consecutive rounds of frames must favour the change before it is made again.
class Trials {
 public:
  /// Adds a round of frames. @param agrees  true if the frames of this round favour the change. @return true
  /// if enough consecutive rounds have favoured the change to make it.
  bool see(bool agrees) noexcept;
  /// Notes that the change was made.
  void begin() noexcept;
  /// Notes that the change was undone. The trial has failed if the change lasted fewer than kTrialFrames
  /// frames.
  void end() noexcept;
  /// Notes that a frame was drawn.
  void passFrame() noexcept;

 private:
  int rounds_ = 0;    ///< number of consecutive rounds that have favoured the change
  int patience_ = 1;  ///< number of consecutive rounds that must favour the change before it is made
  int frames_ = 0;    ///< number of frames that the current change must still last to count as a success
};

/// Holds the frame rate while the camera moves: raises the error threshold if frames take too long. While
/// the camera is at rest, the user's threshold applies. A coarser threshold means fewer triangles and less
/// work. From the time of each frame, the control predicts the threshold that the next frames need. The work
/// per pixel does not depend on the threshold. If this work takes too much of a frame, the control lowers the
/// resolution. If the threshold reaches its limit, the control halves the target frame rate. When frames
/// finish early, the control first restores the frame rate, then the resolution, then the threshold. If a
/// restored rate or resolution proves too slow, more frames must finish early before the next attempt (see
/// Trials). The threshold changes in steps of 2^(1/4), the width and height of the picture in steps of
/// 2^(1/2). Pure: no clock, no GL.
class FrameRateControl {
 public:
  enum class Begin { kFine, kCoarse };

  /// @param fps    frame rate to hold, > 0.
  /// @param begin  threshold of the first frames; kCoarse if a first frame at the user's threshold could take
  /// seconds.
  explicit FrameRateControl(double fps, Begin begin = Begin::kFine) noexcept;

  /// Changes the frame rate to hold. @param fps  > 0.
  void setRate(double fps) noexcept;
  /// Limits the factor by which the threshold is raised. @param coarsening  limit, >= 1; a limit above 8
  /// counts as 8.
  void limitTo(double coarsening) noexcept;
  /// Advances time. @param seconds  time since the last call. @param moved  true if the camera moved in this
  /// time.
  void step(double seconds, bool moved) noexcept;
  /// Adds a drawn frame, which may be several frames old. Ignores frames that were drawn at another
  /// resolution.
  /// @param work_ms  time of the frame, excluding the wait for the display
  void add(double work_ms, const render::Coarsening& coarsening) noexcept;

  /// Returns true if the camera has not moved for a while.
  bool isResting() const noexcept;
  /// Returns the factor by which the next frame's threshold exceeds the user's; 1 while the camera is at
  /// rest.
  double coarsening() const noexcept;
  /// Returns the scale of the next frame's width and height, 0.5 to 1; 1 while the camera is at rest.
  double scale() const noexcept;
  /// Returns true if drawing should wait, because the camera has begun to move and a cut that is much coarser
  /// than the drawn one will arrive soon.
  /// @param coarsening  factor by which the last frame's threshold exceeded the user's, both in pixels of
  ///                    full resolution
  /// @param work_ms     time of the last frame, excluding the wait for the display
  /// @param waited_s    time since the last frame
  bool isWorthWaiting(double coarsening, double work_ms, double waited_s) const noexcept;
  /// Returns the time that a frame may take at the current target rate.
  double targetMs() const noexcept;

 private:
  int mostSteps() const noexcept;
  int wholeSteps(double steps) const noexcept;
  double movingScale() const noexcept;
  void forgetFrames() noexcept;
  void lowerScale(double pixel_load) noexcept;
  void lowerRate() noexcept;
  void ease() noexcept;

  // A frame should take kFill * targetMs(), which is called the planned time below.
  double wanted_ms_;  ///< time of a frame at the rate to hold, before any halving
  int most_steps_;    ///< limit of steps_ at full resolution
  int steps_;         ///< number of steps of 2^(1/4) by which the threshold is raised while the camera moves
  int halvings_ = 0;  ///< number of times that the target frame rate is halved at present
  int scale_steps_ = 0;  ///< index into kScales
  /// Number of steps with which the last frame would have taken the planned time. The threshold is raised
  /// only if two consecutive frames need more than steps_.
  double last_need_ = 0;
  /// Pixel load of the last frame: the time of its work per pixel, divided by the planned time.
  double last_pixel_load_ = 0;
  /// Number of consecutive frames that exceeded the target time at the coarsest threshold.
  int slow_frames_ = 0;
  double least_slow_ = 0;  ///< shortest time of the slow_frames_ frames, divided by the target time
  // Number of calm frames since steps_ was last too small. A frame is calm if steps_ will still suffice after
  // all missing meshes have arrived. The next four members are maxima over the calm frames.
  int calm_frames_ = 0;
  double calm_need_ = 0;  ///< number of steps that the frame needs after all missing meshes have arrived
  double calm_pixel_load_ = 0;  ///< pixel load, as in last_pixel_load_
  /// Number of steps with which twice the work would take kFillOfFaster * targetMs().
  double double_need_ = 0;
  double full_need_ = 0;  ///< number of steps with which twice the work would take the planned time
  Trials rate_, resolution_;
  /// Time since the camera last moved. It starts at 0, so that the first cut can be coarse.
  double still_s_ = 0;
};

}  // namespace lode::app
