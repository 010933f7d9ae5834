#pragma once

#include "client/render/draw_counts.h"

namespace lode::render {

/// Hysteresis for a step that may have to be taken back: each time it is, the next one needs more rounds of
/// frames that vote for it.
class Trials {
 public:
  /// Adds a round of frames. @return true if the step should be taken.
  bool see(bool agrees) noexcept;
  /// The step was taken.
  void begin() noexcept;
  /// The step was taken back: a failure, unless it has lasted kTrialFrames.
  void end() noexcept;
  void passFrame() noexcept;

 private:
  int rounds_ = 0;    ///< consecutive rounds that voted for the step
  int patience_ = 1;  ///< rounds needed
  int frames_ = 0;    ///< frames that the step must still last to count as a success
};

/// Holds a frame rate while the camera moves, by a coarser threshold; at rest the threshold is the user's. A
/// frame's time follows from its triangles, and these from its threshold: each frame predicts how much
/// coarser the next should be. A threshold does not reduce the work per pixel: if that is most of a frame,
/// the resolution drops before the threshold, in its pixels, doubles. If the threshold reaches its limit, the
/// frame rate is halved. When frames leave time, first the rate is restored, then the resolution, then the
/// threshold. Restoring relies on a prediction: after a wrong one, more frames must agree (see Trials).
/// Thresholds move in steps of 2^1/4, the picture's sides in steps of 2^1/2. Pure: no clock, no GL.
class FrameRateControl {
 public:
  enum class Begin { kFine, kCoarse };

  /// @param fps    frame rate to hold, > 0.
  /// @param begin  kCoarse where the first frame with a fine threshold could take seconds.
  explicit FrameRateControl(double fps, Begin begin = Begin::kFine) noexcept;

  /// Changes the rate to hold. @param fps  > 0.
  void setRate(double fps) noexcept;
  /// Limits the coarsening. @param coarsening  >= 1; more than 8 counts as 8.
  void limitTo(double coarsening) noexcept;
  /// Advances time. @param moved  the camera moved.
  void step(double seconds, bool moved) noexcept;
  /// Adds a drawn frame, which may be several frames old. A frame of another resolution than the current one
  /// is ignored.
  /// @param work_ms  time without the wait for the display
  void add(double work_ms, const Coarsening& coarsening) noexcept;

  /// Returns true if the camera has not moved for a while.
  bool isResting() const noexcept;
  /// Factor on the user's threshold for the next frame; 1 while the camera rests.
  double coarsening() const noexcept;
  /// Factor on the picture's sides for the next frame, 0.5 to 1; 1 while the camera rests.
  double scale() const noexcept;
  /// Returns true if drawing should wait: the camera has begun to move, and a much coarser cut than the drawn
  /// one is coming.
  /// @param coarsening  coarsening of the last frame, in pixels of full resolution
  /// @param work_ms     time of the last frame
  /// @param waited_s    time since then
  bool isWorthWaiting(double coarsening, double work_ms, double waited_s) const noexcept;
  /// Time that a frame may take at the current rate.
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
  int most_steps_;              ///< limit of steps_, in pixels of full resolution
  int steps_;                   ///< steps of the threshold while the camera moves
  int halvings_ = 0;            ///< of the frame rate
  int scale_steps_ = 0;         ///< index into kScales
  double last_need_ = 0;        ///< steps that the last frame needed: a single slow frame changes nothing
  double last_pixel_load_ = 0;  ///< the last frame's work per pixel, relative to a frame's time
  int slow_frames_ = 0;         ///< consecutive frames over the target at the coarsest threshold
  double least_slow_ = 0;       ///< fastest of them, relative to the target
  // Consecutive frames that needed no more steps, and their maxima:
  int calm_frames_ = 0;
  double calm_need_ = 0;        ///< steps needed
  double calm_pixel_load_ = 0;  ///< work per pixel, relative to a frame's time
  double double_need_ = 0;      ///< steps needed for twice the work, with the room that a higher rate leaves
  double full_need_ = 0;        ///< steps needed for twice the work at this rate
  Trials rate_, resolution_;
  double still_s_ = 0;  ///< time at rest; starts as if the camera had just moved: the first cut may be coarse
};

}  // namespace lode::render
