#include "client/app/window/panel/panel_layout.h"

#include <gtest/gtest.h>

namespace lode::app {
namespace {

TEST(PanelFit, leavesOutTheRowsOfHighestRank) {
  const std::vector<PanelPart> parts{{2, 10}, {0, 10}, {1, 30}};
  EXPECT_EQ(partsThatFit(parts, 50), (std::vector<bool>{true, true, true}));
  EXPECT_EQ(partsThatFit(parts, 49), (std::vector<bool>{false, true, true}));
  EXPECT_EQ(partsThatFit(parts, 39), (std::vector<bool>{false, true, false})) << "not the last instead";
  EXPECT_EQ(partsThatFit(parts, -5), (std::vector<bool>{false, false, false}));
}

TEST(PanelFit, framesBesideThePanelIfThatLeavesEnoughRoom) {
  const double share = coveredShare({1280, 720}, 15);
  EXPECT_NEAR(share * 1280, double{panelWidthPx(1280, 15)}, 40);
  EXPECT_GT(share * 1280, double{panelWidthPx(1280, 15)});
  EXPECT_EQ(coveredShare({320, 240}, 15), 0);
  EXPECT_EQ(coveredShare({700, 1200}, 15), 0);
}

TEST(PanelFit, putsWindowsSideBySideOnlyWithMarginsAroundBoth) {
  EXPECT_TRUE(fitSideBySide(300, 310, 12, 646));
  EXPECT_FALSE(fitSideBySide(300, 310, 12, 645));
}

std::vector<render::LegendEntry> legendOf(size_t entries) {
  std::vector<render::LegendEntry> legend;
  for (size_t i = 0; i < entries; ++i) legend.push_back({{0, 0, 0}, "node " + std::to_string(i)});
  return legend;
}

TEST(PanelFit, showsALegendInHalfOfTheRoomAndCountsTheRest) {
  const std::vector<render::LegendEntry> legend = legendOf(10);
  EXPECT_EQ(legendThatFits(legend, 20, 400), legend);
  const auto some = legendThatFits(legend, 20, 200);
  ASSERT_EQ(some.size(), 5u);
  EXPECT_EQ(some[3], legend[3]);
  EXPECT_EQ(some[4].meaning, "and 6 more");
  EXPECT_EQ(legendThatFits(legend, 20, 10).size(), 3u);
  EXPECT_EQ(legendThatFits(legend, 20, 10).back().meaning, "and 8 more");
}

TEST(PanelFit, countsTheEntriesBehindTheLegendsLastEntry) {
  std::vector<render::LegendEntry> legend = legendOf(5);
  legend.back().stands_for = 40;
  EXPECT_EQ(legendThatFits(legend, 20, 0).back().meaning, "and 42 more");
}

}  // namespace
}  // namespace lode::app
