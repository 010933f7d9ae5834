#include "client/app/window/panel/panel_content.h"

#include <gtest/gtest.h>

namespace lode::app {
namespace {

TEST(RefiningProgress, advancesEquallyForEachHalvingOfTheError) {
  RefiningProgress progress;
  EXPECT_DOUBLE_EQ(progress.update(16, 1, false), 0);
  EXPECT_DOUBLE_EQ(progress.update(8, 1, false), 0.25);
  EXPECT_DOUBLE_EQ(progress.update(4, 1, false), 0.5);
  EXPECT_DOUBLE_EQ(progress.update(2, 1, false), 0.75);
}

TEST(RefiningProgress, isCompleteOnlyOnConvergence) {
  RefiningProgress progress;
  progress.update(16, 1, false);
  EXPECT_LT(progress.update(1, 1, false), 1);
  EXPECT_LT(progress.update(0, 1, false), 1);
  EXPECT_DOUBLE_EQ(progress.update(1, 1, true), 1);
  EXPECT_DOUBLE_EQ(progress.update(5, 1, true), 1) << "originals that are coarser than asked for";
}

TEST(RefiningProgress, restartsAfterConvergence) {
  RefiningProgress progress;
  progress.update(64, 1, false);
  progress.update(1, 1, true);
  EXPECT_DOUBLE_EQ(progress.update(4, 1, false), 0);
  EXPECT_DOUBLE_EQ(progress.update(2, 1, false), 0.5);
}

TEST(RefiningProgress, neverFallsBelowZeroWhenTheCameraApproaches) {
  RefiningProgress progress;
  progress.update(4, 1, false);
  progress.update(2, 1, false);
  EXPECT_DOUBLE_EQ(progress.update(8, 1, false), 0);
  EXPECT_NEAR(progress.update(4, 1, false), 1 / 3.0, 1e-9);
}

TEST(RefiningProgress, isAlmostCompleteIfTheErrorNeverExceededTheThreshold) {
  RefiningProgress progress;
  const double part = progress.update(0.5f, 1, false);
  EXPECT_GT(part, 0.9);
  EXPECT_LT(part, 1);
}

TEST(PanelContent, differsOnceAShownFigureDoes) {
  PanelContent drawn;
  PanelContent now = drawn;
  now.counts.received_bytes = 1000;
  EXPECT_EQ(differenceOf(now, drawn), Difference::kPicture);
  now = drawn;
  now.counts.texture_bytes = 1000;
  EXPECT_EQ(differenceOf(now, drawn), Difference::kPicture) << "a part of the memory";
}

TEST(PanelContent, ignoresUnshownCountsAndFrameTimes) {
  PanelContent drawn;
  PanelContent now = drawn;
  now.counts.known_nodes = 7;
  now.counts.waited.begin(core::Waiting::kLink, core::TimePoint());
  now.frame_ms = now.upload_ms = 5;
  EXPECT_EQ(differenceOf(now, drawn), Difference::kNone);
}

TEST(PanelContent, doesNotDifferByTheNetworkOnceThePictureHasConverged) {
  PanelContent drawn;
  drawn.converged = true;
  PanelContent now = drawn;
  now.counts.received_bytes = 1'000'000;
  now.counts.link_bytes_per_s = now.counts.round_trip_ms = 9;
  EXPECT_EQ(differenceOf(now, drawn), Difference::kNone);
  now.counts.resident_bytes = 1'000'000;
  EXPECT_EQ(differenceOf(now, drawn), Difference::kPicture);
}

TEST(PanelContent, differsInProgressOnlyWhileTheUserWaits) {
  PanelContent drawn;
  drawn.waiting = "Building scan.ply";
  PanelContent now = drawn;
  now.waited_s = 1;
  EXPECT_EQ(differenceOf(now, drawn), Difference::kProgress);
  now.waiting_part = 0.5;
  now.waiting += "\nsimplify";
  EXPECT_EQ(differenceOf(now, drawn), Difference::kProgress);
  now.message = "saved";
  EXPECT_EQ(differenceOf(now, drawn), Difference::kPicture);
}

TEST(PanelContent, differsInThePictureWhenTheWaitBeginsAndEnds) {
  const PanelContent nothing;
  PanelContent waiting;
  waiting.waiting = "Building scan.ply";
  EXPECT_EQ(differenceOf(waiting, nothing), Difference::kPicture);
  EXPECT_EQ(differenceOf(nothing, waiting), Difference::kPicture);
}

TEST(PanelContent, doesNotDifferByTheTimeBesideAKnownProgress) {
  PanelContent drawn;
  drawn.waiting = "Building scan.ply";
  drawn.waiting_part = 0.5;
  PanelContent now = drawn;
  now.waited_s = 1;
  EXPECT_EQ(differenceOf(now, drawn), Difference::kNone);
}

}  // namespace
}  // namespace lode::app
