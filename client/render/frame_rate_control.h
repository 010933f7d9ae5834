#pragma once

namespace lode::render {

/// Holds a frame rate while the camera moves, by a coarser threshold, and gives it back while the camera
/// rests. What a frame takes follows from its triangles, and these from its threshold: each frame says how
/// much coarser the next ones should be. Where that would be too coarse to fly by, the frame rate is halved
/// instead. Thresholds move in steps of 2^1/4. Pure: no clock, no GL.
class FrameRateControl {
 public:
  /// @param fps  frames a second that are wanted, > 0.
  explicit FrameRateControl(double fps) noexcept : wanted_ms_(1000 / fps) {}

  /// Time passes. @param moved  the camera did.
  void step(double seconds, bool moved) noexcept;
  /// A frame was drawn, however long ago it was asked for.
  /// @param work_ms    without the wait for the display
  /// @param coarsening  of its threshold, the finest one being 1
  void add(double work_ms, double coarsening) noexcept;

  /// The camera has not moved for a while.
  bool isResting() const noexcept;
  /// By what to multiply the finest threshold for the next frame: 1 while the camera rests.
  double coarsening() const noexcept;
  /// What a frame may take now.
  double targetMs() const noexcept;

 private:
  double wanted_ms_;
  int steps_ = 0;         ///< of the threshold, while the camera moves
  int halvings_ = 0;      ///< of the rate
  double last_need_ = 0;  ///< steps; one frame that is slow by accident changes nothing
  int calm_frames_ = 0;   ///< that needed less, one after another
  double still_s_ = 1e9;
};

}  // namespace lode::render
