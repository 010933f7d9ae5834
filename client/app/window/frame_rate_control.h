#pragma once

#include "client/render/draw_counts.h"

namespace lode::app {

/// Hysteresis for a change that may prove wrong and be undone. After each failure, the next change needs more
/// rounds of frames that agree.
class Trials {
 public:
  /// Adds a round of frames. @param agrees  true if the frames agree with the change. @return true if the
  /// change should be made.
  bool see(bool agrees) noexcept;
  /// Notes that the change was made.
  void begin() noexcept;
  /// Notes that the change was undone. The change has failed unless it lasted kTrialFrames.
  void end() noexcept;
  /// Notes that a frame was drawn.
  void passFrame() noexcept;

 private:
  int rounds_ = 0;    ///< number of consecutive rounds that have agreed
  int patience_ = 1;  ///< number of consecutive rounds that must agree before the next change
  int frames_ = 0;    ///< number of further frames that the change must last to count as a success
};

/// Keeps a frame rate while the camera moves, by a coarser threshold. While the camera rests, the threshold
/// is the user's. The time of a frame depends on the number of triangles, and this number depends on the
/// threshold. So each frame predicts how much coarser the next threshold should be. A coarser threshold does
/// not reduce the work per pixel. If this work takes most of a frame, the resolution drops. If the threshold
/// reaches its limit, the frame rate is halved. When frames leave time, the control restores first the rate,
/// then the resolution, then the threshold. A restoration relies on a prediction; after a wrong prediction,
/// more frames must agree (see Trials). The threshold changes in steps of 2^1/4, the sides of the picture in
/// steps of 2^1/2. Pure: no clock, no GL.
class FrameRateControl {
 public:
  enum class Begin { kFine, kCoarse };

  /// @param fps    frame rate to keep, > 0.
  /// @param begin  start of the threshold; kCoarse if the first frame with a fine threshold could take
  /// seconds.
  explicit FrameRateControl(double fps, Begin begin = Begin::kFine) noexcept;

  /// Changes the frame rate to keep. @param fps  > 0.
  void setRate(double fps) noexcept;
  /// Limits the coarsening. @param coarsening  limit, >= 1; more than 8 counts as 8.
  void limitTo(double coarsening) noexcept;
  /// Advances time. @param moved  true if the camera moved.
  void step(double seconds, bool moved) noexcept;
  /// Adds a drawn frame, which may be several frames old. Ignores a frame whose resolution is not the current
  /// resolution.
  /// @param work_ms  time of the frame without the wait for the display
  void add(double work_ms, const render::Coarsening& coarsening) noexcept;

  /// Returns true if the camera has not moved for a while.
  bool isResting() const noexcept;
  /// Returns the factor on the user's threshold for the next frame; 1 while the camera rests.
  double coarsening() const noexcept;
  /// Returns the factor on the picture's sides for the next frame, 0.5 to 1; 1 while the camera rests.
  double scale() const noexcept;
  /// Returns true if drawing should wait, because the camera has begun to move and a cut that is much coarser
  /// than the drawn one will arrive soon.
  /// @param coarsening  coarsening of the last frame, in pixels of full resolution
  /// @param work_ms     time that the last frame took
  /// @param waited_s    time since the last frame
  bool isWorthWaiting(double coarsening, double work_ms, double waited_s) const noexcept;
  /// Returns the time that a frame may take at the current rate.
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
  int most_steps_;       ///< limit of steps_, in pixels of full resolution
  int steps_;            ///< number of steps by which the threshold is coarser while the camera moves
  int halvings_ = 0;     ///< number of current halvings of the frame rate
  int scale_steps_ = 0;  ///< index into kScales
  /// Steps that the last frame needed; only two slow frames in a row change the threshold.
  double last_need_ = 0;
  double last_pixel_load_ = 0;  ///< part of the target time that the last frame's work on pixels took
  /// Number of consecutive frames that exceeded the target at the coarsest threshold.
  int slow_frames_ = 0;
  double least_slow_ = 0;  ///< time of the fastest of the slow_frames_ frames, relative to the target
  // Number of consecutive frames that needed no further steps. The next members are maxima over these frames.
  int calm_frames_ = 0;
  double calm_need_ = 0;        ///< steps needed
  double calm_pixel_load_ = 0;  ///< part of the target time that work on pixels took
  double double_need_ = 0;      ///< steps needed for twice the work in the part kFillOfFaster of the time
  double full_need_ = 0;        ///< steps needed for twice the work in the part kFill of the time
  Trials rate_, resolution_;
  /// Time since the camera last moved; starts at 0, so that the first cut can be coarse.
  double still_s_ = 0;
};

}  // namespace lode::app
