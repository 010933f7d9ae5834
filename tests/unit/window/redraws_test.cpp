#include "client/app/window/redraws.h"

#include <gtest/gtest.h>

#include "client/app/window/panel/panel_content.h"

namespace lode::app {
namespace {

using namespace std::chrono_literals;

constexpr auto kLoop = 10ms;  ///< time between two loops of a window that waits

/// A window whose clock is scripted.
class WaitingWindow {
 public:
  WaitingWindow() {
    content_.waiting = "Building scan.ply";
    look(Difference::kPicture);
    run(1s);
  }

  /// Loops for a time. @return the number of frames drawn.
  int run(std::chrono::milliseconds time) {
    const int before = frames_;
    for (const Redraws::TimePoint end = now_ + time; now_ < end;) {
      now_ += kLoop;
      content_.waited_s += std::chrono::duration<double>(kLoop).count();
      look(differenceOf(content_, drawn_));
    }
    return frames_ - before;
  }
  /// Loops once with a difference. @return the number of frames drawn.
  int look(Difference difference) {
    redraws_.add(difference, now_);
    if (redraws_.frames() == 0) return 0;
    redraws_.draw(now_);
    drawn_ = content_;
    ++frames_;
    return 1;
  }

  PanelContent content_, drawn_;

 private:
  Redraws redraws_;
  Redraws::TimePoint now_{1h};
  int frames_ = 0;
};

TEST(Redraws, drawAtMostFiveFramesInASecondOfWaiting) {
  WaitingWindow window;
  const int frames = window.run(1s);
  EXPECT_LE(frames, 5);
  EXPECT_GE(frames, 4) << "the bar of unknown progress moves";
}

TEST(Redraws, drawNothingWhileAKnownProgressStands) {
  WaitingWindow window;
  window.content_.waiting_part = 0.5;
  window.run(1s);
  EXPECT_EQ(window.run(1s), 0);
}

TEST(Redraws, showProgressWithin200Milliseconds) {
  WaitingWindow window;
  for (const auto before : {0ms, 50ms, 190ms}) {
    window.content_.waiting_part = 0.25;
    window.run(before);
    window.content_.waiting_part = 0.5;
    window.content_.waiting = "Building scan.ply\nsimplify";
    window.run(200ms);
    EXPECT_EQ(window.drawn_.waiting_part, 0.5) << before.count();
    EXPECT_EQ(window.drawn_.waiting, window.content_.waiting) << before.count();
  }
}

TEST(Redraws, drawInputAtOnceWhileTheUserWaits) {
  WaitingWindow window;
  window.content_.waiting_part = 0.5;
  window.run(1s);
  window.content_.waiting_part = 0.6;
  EXPECT_EQ(window.run(10ms), 1);
  window.content_.help = true;  // F1
  EXPECT_EQ(window.run(10ms), 1) << "10 ms after the last frame";
  EXPECT_TRUE(window.drawn_.help);
  EXPECT_EQ(window.run(100ms), Redraws::kFramesToSettle) << "frames until the panel fits its text";
}

TEST(Redraws, drawEachFrameOfAnAnimation) {
  WaitingWindow window;
  for (int i = 0; i < 100; ++i) EXPECT_EQ(window.look(Difference::kPicture), 1) << i;
}

}  // namespace
}  // namespace lode::app
