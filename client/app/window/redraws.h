#pragma once

#include <chrono>

namespace lode::app {

/// Difference between the window's contents and its last picture, in ascending order of urgency.
enum class Difference {
  kNone,
  kProgress,  ///< only the progress that the panel shows while the user waits
  kPicture    ///< anything else, such as the result of input, a new mesh or a moving camera
};

/// Counts the frames that the window has to draw. A difference of the picture is drawn at once and for some
/// frames more. Progress is drawn at most five times a second, because on a software renderer each frame
/// takes CPU time from the work that the user waits for. Pure: no clock, no GL.
class Redraws {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;
  static constexpr int kFramesToSettle = 2;  ///< number of frames until the panel fits its text
  /// Shortest time between a frame and a frame that only shows progress.
  static constexpr std::chrono::milliseconds kProgressInterval{200};

  /// Adds the frames that a difference needs now.
  void add(Difference difference, TimePoint now) noexcept;
  /// Reports that a frame is drawn now.
  void draw(TimePoint now) noexcept;
  int frames() const noexcept { return frames_; }  ///< number of frames to draw without waiting

 private:
  int frames_ = 0;
  TimePoint drawn_{};
};

}  // namespace lode::app
