#pragma once

#include "client/render/shown_thresholds.h"

namespace lode::render {

/// Holds a frame rate while the camera moves, by a coarser threshold, and gives it back while the camera
/// rests. What a frame takes follows from its triangles, and these from its threshold: each frame says how
/// much coarser the next ones should be. Where that would be too coarse to fly by, the frame rate is halved
/// instead, and given back as soon as that is no longer so: the rate comes before the threshold. How soon is
/// a guess, as what a coarser threshold would take is not known: where it was wrong the next one takes more
/// frames that agree. Thresholds move in steps of 2^1/4. Pure: no clock, no GL.
class FrameRateControl {
 public:
  enum class Begin { kFine, kCoarse };

  /// @param fps    frames a second that are wanted, > 0.
  /// @param begin  where the first frame of a fine threshold could take seconds: coarse.
  explicit FrameRateControl(double fps, Begin begin = Begin::kFine) noexcept;

  /// From now on it holds another rate. @param fps  > 0.
  void setRate(double fps) noexcept;
  /// From now on it asks for nothing coarser. @param coarsening  >= 1; eight at most is made use of.
  void limitTo(double coarsening) noexcept;
  /// Time passes. @param moved  the camera did.
  void step(double seconds, bool moved) noexcept;
  /// A frame was drawn, however long ago it was asked for.
  /// @param work_ms  without the wait for the display
  void add(double work_ms, const Coarsening& coarsening) noexcept;

  /// The camera has not moved for a while.
  bool isResting() const noexcept;
  /// By what to multiply the finest threshold for the next frame: 1 while the camera rests.
  double coarsening() const noexcept;
  /// Whether to draw nothing for now, as a much coarser cut than the one that is there is on its way and the
  /// camera moves already.
  /// @param coarsening  of the frame that was drawn last
  /// @param work_ms     that it took
  /// @param waited_s    since then
  bool isWorthWaiting(double coarsening, double work_ms, double waited_s) const noexcept;
  /// What a frame may take now.
  double targetMs() const noexcept;

 private:
  int wholeSteps(double steps) const noexcept;
  void halveRate() noexcept;
  void ease() noexcept;

  double wanted_ms_;
  int most_steps_;          ///< of the threshold,
  int steps_;               ///< and while the camera moves
  int halvings_ = 0;        ///< of the rate
  double last_need_ = 0;    ///< steps; one frame that is slow by accident changes nothing
  int slow_frames_ = 0;     ///< beyond the target at the coarsest threshold, one after another
  int calm_frames_ = 0;     ///< that needed no more, none between them that did,
  double calm_need_ = 0;    ///< the most steps that these needed,
  double faster_need_ = 0;  ///< and those that they would need at twice the rate
  int fast_rounds_ = 0;     ///< of calm frames that could be twice as fast, one after another,
  int patience_ = 1;        ///< and how many of them give the rate back,
  int trial_frames_ = 0;    ///< which is wrong if it is lowered again within so many
  double still_s_ = 0;      ///< it begins as if the camera had moved, so that the first cut may be coarse
};

}  // namespace lode::render
