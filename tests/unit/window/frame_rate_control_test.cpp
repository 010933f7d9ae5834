#include "client/app/window/frame_rate_control.h"

#include <cmath>
#include <deque>

#include <gtest/gtest.h>

namespace lode::app {
namespace {

/// Draws with the threshold requested some frames ago, since a cut takes some frames to arrive.
class Machine {
 public:
  /// @param sharp_ms  time of a frame at the finest threshold, without the constant part.
  Machine(double fixed_ms, double sharp_ms, double power)
      : fixed_ms_(fixed_ms), sharp_ms_(sharp_ms), power_(power) {}

  double workMs(double coarsening) const { return fixed_ms_ + sharp_ms_ * std::pow(coarsening, -power_); }

  /// Draws a frame of a moving or resting camera. @return its time, ms.
  double frame(FrameRateControl& control, bool moved) {
    asked_.push_back(control.coarsening());
    const double drawn = asked_.front();
    if (asked_.size() > kFramesLate) asked_.pop_front();
    const double work_ms = workMs(drawn);
    control.step(std::max(work_ms, 1000.0 / 60) / 1000, moved);
    control.add(work_ms, {drawn, drawn});
    seconds_ += work_ms / 1000;
    return work_ms;
  }
  double seconds() const { return seconds_; }

 private:
  static constexpr size_t kFramesLate = 2;
  double fixed_ms_, sharp_ms_, power_, seconds_ = 0;
  std::deque<double> asked_;
};

TEST(FrameRateControl, findsAThresholdThatTheMachineCanDrawWithinASecond) {
  for (const double power : {1.0, 1.5, 2.0}) {
    for (const double sharp_ms : {10.0, 30.0, 60.0, 120.0, 200.0}) {
      SCOPED_TRACE(testing::Message() << sharp_ms << " ms, power " << power);
      FrameRateControl control(60);
      Machine machine(3, sharp_ms, power);
      while (machine.seconds() < 1) machine.frame(control, true);
      for (int i = 0; i < 600; ++i) ASSERT_LE(machine.frame(control, true), control.targetMs());
    }
  }
}

TEST(FrameRateControl, findsASustainableRateWithinASecondOfSlowFrames) {
  for (const double fixed_ms : {30.0, 60.0, 90.0, 115.0, 130.0}) {
    SCOPED_TRACE(testing::Message() << fixed_ms << " ms");
    FrameRateControl control(60, FrameRateControl::Begin::kCoarse);
    Machine machine(fixed_ms, 2, 1.5);
    while (machine.seconds() < 0.6) machine.frame(control, true);
    for (int i = 0; i < 100; ++i) ASSERT_LE(machine.frame(control, true), control.targetMs());
    EXPECT_LT(control.targetMs(), 2.5 * fixed_ms);
  }
}

TEST(FrameRateControl, keepsItsThresholdWhileWorkStaysTheSame) {
  FrameRateControl control(60);
  Machine machine(3, 150, 1.5);
  for (int i = 0; i < 200; ++i) machine.frame(control, true);
  const double found = control.coarsening();
  for (int i = 0; i < 1000; ++i) {
    machine.frame(control, true);
    ASSERT_EQ(control.coarsening(), found);
  }
}

TEST(FrameRateControl, isNoCoarserThanItHasToBe) {
  for (const double sharp_ms : {20.0, 50.0, 100.0}) {
    FrameRateControl control(60);
    Machine machine(1, sharp_ms, 1.5);
    for (int i = 0; i < 600; ++i) machine.frame(control, true);
    EXPECT_GT(machine.workMs(control.coarsening()), control.targetMs() / 3);
  }
}

TEST(FrameRateControl, refinesAtRestAndRestoresItsThresholdOnMotion) {
  FrameRateControl control(60);
  Machine machine(3, 100, 1.5);
  for (int i = 0; i < 60; ++i) machine.frame(control, true);
  const double moving = control.coarsening();
  EXPECT_GT(moving, 1);
  for (int i = 0; i < 60; ++i) machine.frame(control, false);
  EXPECT_EQ(control.coarsening(), 1);
  control.step(0.016, true);
  EXPECT_NEAR(std::log2(control.coarsening()), std::log2(moving), 0.5);
}

TEST(FrameRateControl, leavesAFastMachineAlone) {
  FrameRateControl control(60);
  Machine machine(2, 9, 1.5);
  for (int i = 0; i < 600; ++i) {
    machine.frame(control, true);
    ASSERT_EQ(control.coarsening(), 1);
  }
}

TEST(FrameRateControl, changesNothingForOneSlowFrame) {
  FrameRateControl control(60);
  for (int i = 0; i < 100; ++i) {
    control.step(0.016, true);
    control.add(i % 10 == 0 ? 200 : 8, {});
    ASSERT_EQ(control.coarsening(), 1);
  }
}

TEST(FrameRateControl, halvesTheRateWhereTheThresholdWouldBeTooCoarse) {
  FrameRateControl control(60);
  Machine machine(20, 100, 1.5);  // too slow for 60 frames a second
  for (int i = 0; i < 100; ++i) machine.frame(control, true);
  EXPECT_NEAR(control.targetMs(), 2 * 1000.0 / 60, 1e-9);
  EXPECT_LE(machine.workMs(control.coarsening()), control.targetMs());
}

TEST(FrameRateControl, givesTheRateBackWhenFramesBecomeCheap) {
  FrameRateControl control(60);
  Machine slow(20, 100, 1.5), fast(1, 5, 1.5);
  for (int i = 0; i < 100; ++i) slow.frame(control, true);
  for (int i = 0; i < 300; ++i) fast.frame(control, true);
  EXPECT_NEAR(control.targetMs(), 1000.0 / 60, 1e-9);
  EXPECT_EQ(control.coarsening(), 1);
}

TEST(FrameRateControl, keepsTheHighestRateThatTheCoarsestThresholdSustains) {
  FrameRateControl control(60);
  Machine slow(20, 400, 1.5), cheaper(12, 40, 1.5);  // fast enough for 60 frames a second, but only just
  for (int i = 0; i < 100; ++i) slow.frame(control, true);
  ASSERT_GT(control.targetMs(), 1000.0 / 60);
  for (int i = 0; i < 100; ++i) cheaper.frame(control, true);
  EXPECT_NEAR(control.targetMs(), 1000.0 / 60, 1e-9);
}

/// Counts the changes of the rate in a number of frames.
int changesOfRate(FrameRateControl& control, Machine& machine, int frames) {
  int changes = 0;
  for (int i = 0; i < frames; ++i) {
    const double target_ms = control.targetMs();
    machine.frame(control, true);
    changes += control.targetMs() != target_ms ? 1 : 0;
  }
  return changes;
}

TEST(FrameRateControl, seldomRetriesAnUnsustainableRate) {
  for (double fixed_ms = 13; fixed_ms <= 36; fixed_ms += 0.5) {
    for (const double sharp_ms : {10.0, 45.0, 100.0}) {
      for (const double power : {1.0, 1.5, 2.0}) {
        SCOPED_TRACE(testing::Message() << fixed_ms << " and " << sharp_ms << " ms, power " << power);
        FrameRateControl control(60);
        Machine machine(fixed_ms, sharp_ms, power);
        changesOfRate(control, machine, 500);
        EXPECT_LE(changesOfRate(control, machine, 2000), 2);
      }
    }
  }
}

TEST(FrameRateControl, triesARateAgainSoonWhereItLastedBefore) {
  FrameRateControl control(60);
  Machine slow(20, 100, 1.5), fast(1, 5, 1.5);
  for (int i = 0; i < 5; ++i) {
    for (int j = 0; j < 100; ++j) slow.frame(control, true);
    EXPECT_GT(control.targetMs(), 1000.0 / 60);
    for (int j = 0; j < 100; ++j) fast.frame(control, true);
    EXPECT_NEAR(control.targetMs(), 1000.0 / 60, 1e-9);
  }
}

TEST(FrameRateControl, halvesNoRateForTwoSlowFrames) {
  FrameRateControl control(60, FrameRateControl::Begin::kCoarse);
  control.step(0.016, true);
  for (int i = 0; i < 100; ++i) control.add(i % 10 < 2 ? 200 : 12, {8, 8});
  EXPECT_NEAR(control.targetMs(), 1000.0 / 60, 1e-9);
}

TEST(FrameRateControl, refinesSoonOnAFastMachineIfItBeginsCoarse) {
  FrameRateControl control(60, FrameRateControl::Begin::kCoarse);
  Machine machine(0.5, 5, 1.5);
  machine.frame(control, true);
  EXPECT_EQ(control.coarsening(), 8);
  for (int i = 0; i < 60; ++i) machine.frame(control, true);
  EXPECT_EQ(control.coarsening(), 1);
}

TEST(FrameRateControl, requestsACoarseFirstCutAtRestIfItBeginsCoarse) {
  FrameRateControl control(60, FrameRateControl::Begin::kCoarse);
  control.step(0.1, false);
  EXPECT_EQ(control.coarsening(), 8);
  control.step(0.2, false);
  EXPECT_EQ(control.coarsening(), 1);
}

TEST(FrameRateControl, doesNotRefineByIncompleteFrames) {
  FrameRateControl control(60, FrameRateControl::Begin::kCoarse);
  control.step(0.016, true);
  for (int i = 0; i < 100; ++i) control.add(0.5, {8, 100});
  EXPECT_EQ(control.coarsening(), 8);
}

TEST(FrameRateControl, refinesDespiteIncompleteFramesInBetween) {
  FrameRateControl control(60, FrameRateControl::Begin::kCoarse);
  control.step(0.016, true);
  for (int i = 0; i < 3; ++i) control.add(20, {8, 8});
  ASSERT_GT(control.targetMs(), 1000.0 / 60);
  for (int i = 0; i < 100; ++i) control.add(2, {8, i % 3 == 0 ? 8.0 : 100.0});
  EXPECT_NEAR(control.targetMs(), 1000.0 / 60, 1e-9);
  EXPECT_LT(control.coarsening(), 8);
}

TEST(FrameRateControl, refinesByIncompleteFramesWithTimeForTheRest) {
  FrameRateControl control(60, FrameRateControl::Begin::kCoarse);
  control.step(0.016, true);
  for (int i = 0; i < 100; ++i) control.add(1, {8, 10});
  EXPECT_LT(control.coarsening(), 8);
}

TEST(FrameRateControl, keepsTheRateIfSlowFramesAreFinerThanRequested) {
  FrameRateControl control(60, FrameRateControl::Begin::kCoarse);
  control.step(0.016, true);
  for (int i = 0; i < 100; ++i) control.add(300, {4, 4});
  EXPECT_NEAR(control.targetMs(), 1000.0 / 60, 1e-9);
}

TEST(FrameRateControl, becomesCoarserByFramesThatLackSomething) {
  FrameRateControl control(60);
  control.step(0.016, true);
  for (int i = 0; i < 2; ++i) control.add(40, {1, 5});
  EXPECT_GT(control.coarsening(), 1);
}

TEST(FrameRateControl, waitsForACoarserCutWhereAFrameOfTheFineOneTakesLonger) {
  FrameRateControl control(60, FrameRateControl::Begin::kCoarse);
  control.step(1, false);
  EXPECT_FALSE(control.isWorthWaiting(1, 800, 0)) << "at rest nothing coarser is asked for";
  control.step(0.016, true);
  EXPECT_TRUE(control.isWorthWaiting(1, 800, 0.2));
  EXPECT_FALSE(control.isWorthWaiting(1, 800, 0.3)) << "too long";
  EXPECT_FALSE(control.isWorthWaiting(1, 100, 0.06)) << "longer than half a frame";
  EXPECT_FALSE(control.isWorthWaiting(1, 20, 0)) << "frames are fast";
  EXPECT_FALSE(control.isWorthWaiting(7, 800, 0)) << "hardly coarser";
}

TEST(FrameRateControl, neverRequestsMoreThanItsCoarsestThreshold) {
  FrameRateControl control(60, FrameRateControl::Begin::kCoarse);
  control.limitTo(4);
  control.step(0.016, true);
  EXPECT_EQ(control.coarsening(), 4);
  for (int i = 0; i < 3; ++i) control.add(400, {4, 4});
  EXPECT_EQ(control.coarsening(), 4);
  control.limitTo(1.1);
  EXPECT_EQ(control.coarsening(), 1);
}

TEST(FrameRateControl, halvesTheRateIfItsCoarsestThresholdIsNotEnough) {
  FrameRateControl control(60);
  control.limitTo(4);
  Machine machine(3, 160, 1.5);  // an eightfold threshold suffices
  for (int i = 0; i < 100; ++i) machine.frame(control, true);
  EXPECT_NEAR(control.targetMs(), 2 * 1000.0 / 60, 1e-9);
  EXPECT_LE(machine.workMs(control.coarsening()), control.targetMs());
}

TEST(FrameRateControl, neverWaitsForMoreThanItsCoarsestThreshold) {
  FrameRateControl control(60, FrameRateControl::Begin::kCoarse);
  control.limitTo(4);
  control.step(0.016, true);
  EXPECT_TRUE(control.isWorthWaiting(1, 800, 0));
  EXPECT_FALSE(control.isWorthWaiting(4, 800, 0));
}

TEST(FrameRateControl, restsWhenTheCameraHasNotMovedForAQuarterOfASecond) {
  FrameRateControl control(60);
  control.step(0.1, true);
  EXPECT_FALSE(control.isResting());
  control.step(0.2, false);
  EXPECT_FALSE(control.isResting());
  control.step(0.06, false);
  EXPECT_TRUE(control.isResting());
}

}  // namespace
}  // namespace lode::app
