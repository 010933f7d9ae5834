#include "client/app/window/panel/panel_content.h"

#include <gtest/gtest.h>

namespace lode::app {
namespace {

TEST(RefiningProgress, isAsFarForEachHalvingOfTheError) {
  RefiningProgress progress;
  EXPECT_DOUBLE_EQ(progress.update(16, 1, false), 0);
  EXPECT_DOUBLE_EQ(progress.update(8, 1, false), 0.25);
  EXPECT_DOUBLE_EQ(progress.update(4, 1, false), 0.5);
  EXPECT_DOUBLE_EQ(progress.update(2, 1, false), 0.75);
}

TEST(RefiningProgress, isWholeOnlyWhereItHasConverged) {
  RefiningProgress progress;
  progress.update(16, 1, false);
  EXPECT_LT(progress.update(1, 1, false), 1);
  EXPECT_LT(progress.update(0, 1, false), 1);
  EXPECT_DOUBLE_EQ(progress.update(1, 1, true), 1);
  EXPECT_DOUBLE_EQ(progress.update(5, 1, true), 1) << "originals that are coarser than asked for";
}

TEST(RefiningProgress, beginsAnewAfterItHasConverged) {
  RefiningProgress progress;
  progress.update(64, 1, false);
  progress.update(1, 1, true);
  EXPECT_DOUBLE_EQ(progress.update(4, 1, false), 0);
  EXPECT_DOUBLE_EQ(progress.update(2, 1, false), 0.5);
}

TEST(RefiningProgress, fallsBackToNoLessThanNothingWhereTheCameraComesNearer) {
  RefiningProgress progress;
  progress.update(4, 1, false);
  progress.update(2, 1, false);
  EXPECT_DOUBLE_EQ(progress.update(8, 1, false), 0);
  EXPECT_NEAR(progress.update(4, 1, false), 1 / 3.0, 1e-9);
}

TEST(RefiningProgress, isAlmostWholeWhereTheErrorNeverWasAboveTheThreshold) {
  RefiningProgress progress;
  const double part = progress.update(0.5f, 1, false);
  EXPECT_GT(part, 0.9);
  EXPECT_LT(part, 1);
}

}  // namespace
}  // namespace lode::app
