#include <algorithm>
#include <cmath>
#include <deque>

#include <gtest/gtest.h>

#include "client/app/window/frame_rate_control.h"

namespace lode::app {
namespace {

/// A CPU that draws with the threshold and resolution requested some frames ago.
class SlowMachine {
 public:
  /// @param pixels_ms  time for all pixels.
  /// @param sharp_ms   time for the triangles at a threshold of one pixel.
  /// @param bias       error of the estimated share of pixels: > 1 is too large.
  SlowMachine(double pixels_ms, double sharp_ms, double bias = 1)
      : pixels_ms_(pixels_ms), sharp_ms_(sharp_ms), bias_(bias) {}

  /// Draws a frame of a moving camera. @return its time, ms.
  double frame(FrameRateControl& control) {
    asked_.push_back({control.coarsening(), control.scale()});
    const Asked drawn = asked_.front();
    if (asked_.size() > kFramesLate) asked_.pop_front();
    const double pixels_ms = pixels_ms_ * drawn.scale * drawn.scale;
    const double triangles_ms = sharp_ms_ * std::pow(drawn.coarsening / drawn.scale, -1.5);
    const double share = bias_ * pixels_ms / (bias_ * pixels_ms + triangles_ms);
    const double work_ms = pixels_ms + triangles_ms;
    control.step(std::max(work_ms, 1000.0 / 60) / 1000, true);
    control.add(work_ms, {drawn.coarsening, drawn.coarsening, share, drawn.scale});
    seconds_ += work_ms / 1000;
    return work_ms;
  }
  double seconds() const { return seconds_; }

 private:
  struct Asked {
    double coarsening, scale;
  };
  static constexpr size_t kFramesLate = 2;
  double pixels_ms_, sharp_ms_, bias_, seconds_ = 0;
  std::deque<Asked> asked_;
};

void fly(FrameRateControl& control, SlowMachine machine, int frames) {
  for (int i = 0; i < frames; ++i) machine.frame(control);
}

constexpr double kWantedMs = 1000.0 / 60;

TEST(FrameRateResolution, fallsIfPixelsDominateTheFrameTime) {
  for (const double pixels_ms : {15.0, 20.0, 25.0}) {
    SCOPED_TRACE(testing::Message() << pixels_ms << " ms");
    FrameRateControl control(60);
    fly(control, {pixels_ms, 40}, 300);
    EXPECT_LT(control.scale(), 1);
    EXPECT_NEAR(control.targetMs(), kWantedMs, 1e-9);
    EXPECT_LT(control.coarsening(), 4);
  }
}

TEST(FrameRateResolution, staysIfTrianglesDominateTheFrameTime) {
  FrameRateControl control(60);
  SlowMachine machine(5, 150);
  for (int i = 0; i < 600; ++i) {
    machine.frame(control);
    ASSERT_EQ(control.scale(), 1);
  }
  EXPECT_GT(control.coarsening(), 2);
}

TEST(FrameRateResolution, isFoundWithinASecondFromAnyStart) {
  for (const auto begin : {FrameRateControl::Begin::kFine, FrameRateControl::Begin::kCoarse}) {
    for (const double pixels_ms : {5.0, 20.0, 40.0, 100.0}) {
      for (const double sharp_ms : {0.5, 20.0, 100.0}) {
        if (begin == FrameRateControl::Begin::kFine && pixels_ms + sharp_ms > 150) continue;
        SCOPED_TRACE(testing::Message() << pixels_ms << " and " << sharp_ms << " ms");
        FrameRateControl control(60, begin);
        SlowMachine machine(pixels_ms, sharp_ms);
        while (machine.seconds() < 1) machine.frame(control);
        for (int i = 0; i < 600; ++i) ASSERT_LE(machine.frame(control), control.targetMs());
      }
    }
  }
}

/// Counts the changes of resolution or rate in a number of frames.
int changesOf(FrameRateControl& control, SlowMachine& machine, int frames) {
  int changes = 0;
  for (int i = 0; i < frames; ++i) {
    const double target_ms = control.targetMs(), scale = control.scale();
    machine.frame(control);
    changes += control.targetMs() != target_ms || control.scale() != scale ? 1 : 0;
  }
  return changes;
}

TEST(FrameRateResolution, seldomChangesWhileWorkIsConstantEvenIfMisattributed) {
  for (const double bias : {0.3, 1.0, 3.0}) {
    for (double pixels_ms = 2; pixels_ms <= 60; pixels_ms += 1.5) {
      for (const double sharp_ms : {1.0, 20.0, 60.0, 200.0}) {
        SCOPED_TRACE(testing::Message() << pixels_ms << " and " << sharp_ms << " ms, taken for " << bias);
        FrameRateControl control(60, FrameRateControl::Begin::kCoarse);
        SlowMachine machine(pixels_ms, sharp_ms, bias);
        changesOf(control, machine, bias < 1 ? 1000 : 100);  // patience grows with each wrong guess
        EXPECT_LE(changesOf(control, machine, 3000), 2);
      }
    }
  }
}

TEST(FrameRateResolution, isRestoredWhenPixelsBecomeCheap) {
  FrameRateControl control(60);
  fly(control, {30, 40}, 100);
  ASSERT_EQ(control.scale(), 0.5);
  fly(control, {2, 10}, 300);
  EXPECT_EQ(control.scale(), 1);
  EXPECT_EQ(control.coarsening(), 1);
}

TEST(FrameRateResolution, isRestoredEvenIfTrianglesDominateTheFrameTime) {
  FrameRateControl control(60);
  fly(control, {30, 40}, 100);
  ASSERT_EQ(control.scale(), 0.5);
  fly(control, {3, 200}, 600);
  EXPECT_EQ(control.scale(), 1);
}

TEST(FrameRateResolution, isFullAtRestAndRestoredOnMotion) {
  FrameRateControl control(60);
  fly(control, {30, 40}, 100);
  const double found = control.scale();
  ASSERT_LT(found, 1);
  control.step(1, false);
  EXPECT_EQ(control.scale(), 1);
  control.step(0.016, true);
  EXPECT_EQ(control.scale(), found);
}

TEST(FrameRateResolution, ignoresOneSlowFrame) {
  FrameRateControl control(60);
  control.step(0.016, true);
  for (int i = 0; i < 100; ++i) control.add(i % 10 == 0 ? 200 : 8, {1, 1, 0.9, 1});
  EXPECT_EQ(control.scale(), 1);
}

TEST(FrameRateResolution, limitsTheTotalCoarseningToEight) {
  FrameRateControl control(60);
  fly(control, {60, 1000}, 100);
  EXPECT_EQ(control.scale(), 0.5);
  EXPECT_EQ(control.coarsening(), 4);
  EXPECT_GT(control.targetMs(), kWantedMs);
}

TEST(FrameRateResolution, ignoresFramesOfAnotherResolution) {
  FrameRateControl control(60);
  control.step(0.016, true);
  for (int i = 0; i < 100; ++i) control.add(200, {1, 1, 0.9, 0.5});
  EXPECT_EQ(control.scale(), 1);
  EXPECT_EQ(control.coarsening(), 1);
}

}  // namespace
}  // namespace lode::app
