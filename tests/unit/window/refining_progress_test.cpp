#include "client/app/window/panel/refining_progress.h"

#include <gtest/gtest.h>

namespace lode::app {
namespace {

TEST(RefiningProgress, isAsFarForEachHalvingOfTheError) {
  RefiningProgress progress;
  EXPECT_DOUBLE_EQ(progress.see(16, 1, false), 0);
  EXPECT_DOUBLE_EQ(progress.see(8, 1, false), 0.25);
  EXPECT_DOUBLE_EQ(progress.see(4, 1, false), 0.5);
  EXPECT_DOUBLE_EQ(progress.see(2, 1, false), 0.75);
}

TEST(RefiningProgress, isWholeOnlyWhereItHasConverged) {
  RefiningProgress progress;
  progress.see(16, 1, false);
  EXPECT_LT(progress.see(1, 1, false), 1);
  EXPECT_LT(progress.see(0, 1, false), 1);
  EXPECT_DOUBLE_EQ(progress.see(1, 1, true), 1);
  EXPECT_DOUBLE_EQ(progress.see(5, 1, true), 1) << "originals that are coarser than asked for";
}

TEST(RefiningProgress, beginsAnewAfterItHasConverged) {
  RefiningProgress progress;
  progress.see(64, 1, false);
  progress.see(1, 1, true);
  EXPECT_DOUBLE_EQ(progress.see(4, 1, false), 0);
  EXPECT_DOUBLE_EQ(progress.see(2, 1, false), 0.5);
}

TEST(RefiningProgress, fallsBackToNoLessThanNothingWhereTheCameraComesNearer) {
  RefiningProgress progress;
  progress.see(4, 1, false);
  progress.see(2, 1, false);
  EXPECT_DOUBLE_EQ(progress.see(8, 1, false), 0);
  EXPECT_NEAR(progress.see(4, 1, false), 1 / 3.0, 1e-9);
}

TEST(RefiningProgress, isAlmostWholeWhereTheErrorNeverWasAboveTheThreshold) {
  RefiningProgress progress;
  const double part = progress.see(0.5f, 1, false);
  EXPECT_GT(part, 0.9);
  EXPECT_LT(part, 1);
}

}  // namespace
}  // namespace lode::app
