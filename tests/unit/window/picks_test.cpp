#include "client/app/window/scene/picks.h"

#include <gtest/gtest.h>

namespace lode::app {
namespace {

PickedPoint pointAt(double x) {
  PickedPoint point;
  point.position = {x, 0, 0};
  return point;
}

TEST(Picks, tellHowFarTheLastTwoAreApart) {
  Picks picks;
  for (const double x : {5.0, 1.0, 3.0}) picks.add(pointAt(x));
  EXPECT_EQ(picks.lines().front(), "3 0 0");
  EXPECT_EQ(picks.lines().back(), "distance 2");
}

TEST(Picks, areRestoredWhenAClickIsUndone) {
  Picks picks;
  picks.add(pointAt(1));
  picks.add(pointAt(2));
  const auto before = picks.lines();
  picks.add(pointAt(7));
  picks.takeBack();
  EXPECT_EQ(picks.lines(), before);
  picks.clear();
  picks.takeBack();
  EXPECT_EQ(picks.lines(), before);
}

}  // namespace
}  // namespace lode::app
