#pragma once

#include "client/render/shown_thresholds.h"

namespace lode::render {

/// A choice that may turn out to be wrong: where it does, it takes more rounds that agree to make it again.
class Trials {
 public:
  /// @param agrees  what was seen of a round of frames. @return whether it is to be made.
  bool see(bool agrees) noexcept;
  void begin() noexcept;
  /// It was taken back: wrong, unless it has lasted.
  void end() noexcept;
  void passFrame() noexcept;

 private:
  int rounds_ = 0;    ///< that agree, one after another,
  int patience_ = 1;  ///< and how many of them are enough,
  int frames_ = 0;    ///< for which it has yet to last
};

/// Holds a frame rate while the camera moves, by a coarser threshold, and gives it back while the camera
/// rests. What a frame takes follows from its triangles, and these from its threshold: each frame says how
/// much coarser the next ones should be. What goes by its pixels no threshold makes less: where that is most
/// of what a frame may take, the picture gets fewer pixels before its threshold, which is in these pixels,
/// becomes more than twice as coarse. Where all that would be too coarse to fly by, the frame rate is halved
/// instead, as often as frames say. The rate is given back first, then pixels, then the threshold, as soon as
/// frames say that there is time for it. That is a guess, as what frames would take is not known: where it
/// was wrong the next one takes more frames that agree. Thresholds move in steps of 2^1/4, the picture's
/// sides in steps of 2^1/2. Pure: no clock, no GL.
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
  /// A frame was drawn, however long ago it was asked for. One of another resolution than is asked for now
  /// tells nothing.
  /// @param work_ms  without the wait for the display
  void add(double work_ms, const Coarsening& coarsening) noexcept;

  /// The camera has not moved for a while.
  bool isResting() const noexcept;
  /// By what to multiply the finest threshold for the next frame: 1 while the camera rests.
  double coarsening() const noexcept;
  /// By what to multiply the picture's sides for it, 0.5 to 1: 1 while the camera rests.
  double scale() const noexcept;
  /// Whether to draw nothing for now, as a much coarser cut than the one that is there is on its way and the
  /// camera moves already.
  /// @param coarsening  of the frame that was drawn last, by the pixels of all of the resolution
  /// @param work_ms     that it took
  /// @param waited_s    since then
  bool isWorthWaiting(double coarsening, double work_ms, double waited_s) const noexcept;
  /// What a frame may take now.
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
  int most_steps_;              ///< of the threshold in the window's pixels,
  int steps_;                   ///< and while the camera moves
  int halvings_ = 0;            ///< of the rate,
  int scale_steps_ = 0;         ///< and of the resolution
  double last_need_ = 0;        ///< steps; one frame that is slow by accident changes nothing,
  double last_pixel_load_ = 0;  ///< of what a frame may take, that its pixels do
  int slow_frames_ = 0;         ///< beyond the target at the coarsest threshold, one after another,
  double least_slow_ = 0;       ///< and the least of them, of the target
  int calm_frames_ = 0;         ///< that needed no more, none between them that did,
  double calm_need_ = 0;        ///< the most steps that these needed,
  double calm_pixel_load_ = 0;
  double double_need_ = 0;  ///< those that they would need for twice the work in a higher rate,
  double full_need_ = 0;    ///< and in this one
  Trials rate_, resolution_;
  double still_s_ = 0;  ///< it begins as if the camera had moved, so that the first cut may be coarse
};

}  // namespace lode::render
