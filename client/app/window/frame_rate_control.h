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
  int patience_ = 1;  ///< number of consecutive rounds that must favour the next change
  int frames_ = 0;    ///< number of frames that the current change must still last to count as a success
};

/// Holds the frame rate while the camera moves by raising the error threshold. While the camera is at rest,
/// the user's threshold applies. A coarser threshold means fewer triangles and less work, so the control uses
/// the time of each frame to predict the threshold that the next frames need. The work per pixel does not
/// depend on the threshold. If this work takes too much of a frame, the control lowers the resolution. If the
/// threshold reaches its limit, the control halves the target frame rate. When frames finish early, the
/// control first restores the frame rate, then the resolution, then the threshold. After a restored rate or
/// resolution has proved too slow, more frames must finish early before the next attempt (see Trials). The
/// threshold changes in steps of 2^(1/4), the width and height of the picture in steps of 2^(1/2). Pure: no
/// clock, no GL.
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
  /// Advances time. @param moved  true if the camera moved.
  void step(double seconds, bool moved) noexcept;
  /// Adds a drawn frame, which may be several frames old. Ignores frames that were drawn at another
  /// resolution.
  /// @param work_ms  time of the frame, excluding the wait for the display
  void add(double work_ms, const render::Coarsening& coarsening) noexcept;

  /// Returns true if the camera has not moved for a while.
  bool isResting() const noexcept;
  /// Returns the factor on the user's threshold for the next frame; 1 while the camera is at rest.
  double coarsening() const noexcept;
  /// Returns the scale of the next frame's width and height, 0.5 to 1; 1 while the camera is at rest.
  double scale() const noexcept;
  /// Returns true if drawing should wait, because the camera has begun to move and a cut that is much coarser
  /// than the drawn one will arrive soon.
  /// @param coarsening  factor on the user's threshold in the last frame, in pixels of full resolution
  /// @param work_ms     time that the last frame took
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

  double wanted_ms_;
  int most_steps_;    ///< limit of steps_ at full resolution
  int steps_;         ///< number of steps of 2^(1/4) by which the threshold is raised while the camera moves
  int halvings_ = 0;  ///< number of times that the target frame rate is halved at present
  int scale_steps_ = 0;  ///< index into kScales
  /// Number of steps that the last frame called for. The threshold is raised only if two frames in a row call
  /// for it.
  double last_need_ = 0;
  /// Time that the last frame spent on work per pixel, relative to kFill of the target time.
  double last_pixel_load_ = 0;
  /// Number of consecutive frames that exceeded the target time at the coarsest threshold.
  int slow_frames_ = 0;
  double least_slow_ = 0;  ///< time of the fastest of the slow_frames_ frames, relative to the target time
  // Number of calm frames since steps_ was last too small. A frame is calm if steps_ would suffice even with
  // no mesh missing. The next four members are maxima over the calm frames.
  int calm_frames_ = 0;
  double calm_need_ = 0;        ///< number of steps called for
  double calm_pixel_load_ = 0;  ///< work per pixel, measured like last_pixel_load_
  /// Number of steps at which twice the work fits into kFillOfFaster of the target time.
  double double_need_ = 0;
  double full_need_ = 0;  ///< number of steps at which twice the work fits into kFill of the target time
  Trials rate_, resolution_;
  /// Time since the camera last moved. It starts at 0, so that the first cut can be coarse.
  double still_s_ = 0;
};

}  // namespace lode::app
