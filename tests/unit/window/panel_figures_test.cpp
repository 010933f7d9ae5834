#include "client/app/window/panel/panel_figures.h"

#include <algorithm>

#include <gtest/gtest.h>

namespace lode::app {
namespace {

std::string valueOf(const PanelContent& content, std::string_view name) {
  for (const Figure& figure : figuresOf(content))
    if (figure.name == name) return figure.value;
  return "missing";
}

TEST(PanelFigures, sayHowManyRequestsOfEachClassAreOpen) {
  PanelContent content;
  EXPECT_EQ(valueOf(content, "requests"), "none");
  content.counts.requests = {1200, 3, 0, 7};
  EXPECT_EQ(valueOf(content, "requests"), "visible 1\u00a0200, margin 3, prefetch 0") << "no line ends in it";
}

TEST(PanelFigures, leaveOutUnmeasuredValues) {
  PanelContent content;
  content.counts.received_bytes = 1000;
  EXPECT_EQ(valueOf(content, "network"), "1.0 KB");
  content.counts.round_trip_ms = 0.01;
  EXPECT_EQ(valueOf(content, "network"), "1.0 KB") << "0.0 ms would be said";
  content.counts.link_bytes_per_s = 2000;
  content.counts.round_trip_ms = 12;
  EXPECT_EQ(valueOf(content, "network"), "1.0 KB, 2.0 KB/s, 12.0 ms round trip");
}

TEST(PanelFigures, showWhetherTheTargetRateIsReached) {
  PanelContent content;
  content.threshold_px = content.final_threshold_px = 2;
  content.frame_ms = 132.7;
  EXPECT_EQ(valueOf(content, "threshold"), "2.00 px") << "at rest no rate is aimed at";
  content.target_ms = 1000.0 / 30;
  EXPECT_EQ(valueOf(content, "threshold"),
            "2.00 px while moving, for at least 30 frames per second, not reached");
  content.frame_ms = 35;
  EXPECT_EQ(valueOf(content, "threshold"), "2.00 px while moving, for at least 30 frames per second");
}

TEST(PanelFigures, speakOfNoMotionWhileTheFirstPicturesAreCoarse) {
  PanelContent content;
  content.threshold_px = 8;
  content.final_threshold_px = 1;
  content.scale = 0.5;
  content.frame_ms = 500;
  content.aimed_ms = 1000.0 / 60;
  EXPECT_EQ(valueOf(content, "threshold"), "8.00 px at first, then 1.00 px");
  EXPECT_EQ(valueOf(content, "pixels"), "25 % at first");
}

TEST(PanelFigures, haveDistinctRanks) {
  PanelContent content;
  content.textured = true;
  content.scale = 0.5;
  const std::vector<Figure> figures = figuresOf(content);
  std::vector<int> ranks;
  for (const Figure& figure : figures) ranks.push_back(figure.rank);
  std::ranges::sort(ranks);
  EXPECT_EQ(std::ranges::adjacent_find(ranks), ranks.end());
}

}  // namespace
}  // namespace lode::app
