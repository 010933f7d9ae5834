#include "client/app/window/scene/picks.h"

#include <gtest/gtest.h>

namespace lode::app {
namespace {

const glm::dvec3 kUpwards(0, 0, 1);

PickedPoint pointAt(double x) {
  PickedPoint point;
  point.position = {x, 0, 0};
  return point;
}

TEST(Picks, tellHowFarTheLastTwoAreApart) {
  Picks picks;
  for (const double x : {5.0, 1.0, 3.0}) picks.add(pointAt(x));
  EXPECT_EQ(picks.lines(kUpwards, "").front(), "3 0 0");
  EXPECT_EQ(picks.lines(kUpwards, "").back(), "distance 2 \u00b1 2")
      << "off by half a lattice cell at each end";
}

TEST(Picks, bearTheErrorsOfBothEndsAndTheUnit) {
  Picks picks;
  for (const double x : {1.0, 3.0}) {
    PickedPoint point = pointAt(x);
    point.step = 1e-6;
    point.error = x / 100;
    picks.add(point);
  }
  EXPECT_EQ(valueText(picks.current(), kUpwards, ""), "2.000 \u00b1 0.040");
  EXPECT_EQ(valueText(picks.current(), kUpwards, "mm"), "2.000 \u00b1 0.040 mm");
  PickedPoint finer = pointAt(1.1);
  finer.step = 1e-6;
  finer.error = 0.001;
  picks.measures().back()->points[0] = finer;
  EXPECT_EQ(valueText(picks.current(), kUpwards, "mm"), "1.900 \u00b1 0.031 mm");
}

TEST(Picks, areUnsavedOnceOneIsKept) {
  Picks picks;
  picks.add(pointAt(1));
  picks.add(pointAt(2));
  EXPECT_FALSE(picks.hasUnsaved()) << "an open measurement";
  picks.keep();
  EXPECT_TRUE(picks.hasUnsaved());
  picks.markSaved();
  EXPECT_FALSE(picks.hasUnsaved());
  picks.dropLast();
  EXPECT_FALSE(picks.hasUnsaved()) << "nothing is kept";
}

TEST(Picks, onASectionHaveNoNode) {
  Picks picks;
  PickedPoint point = pointAt(1);
  point.is_on_cut = true;
  picks.add(point);
  EXPECT_EQ(picks.lines(kUpwards, "").back(), "the section");
}

TEST(Picks, areRestoredWhenAClickIsUndone) {
  Picks picks;
  picks.add(pointAt(1));
  picks.add(pointAt(2));
  const auto before = picks.lines(kUpwards, "");
  picks.add(pointAt(7));
  picks.takeBack();
  EXPECT_EQ(picks.lines(kUpwards, ""), before);
  picks.clear();
  picks.takeBack();
  EXPECT_EQ(picks.lines(kUpwards, ""), before);
}

}  // namespace
}  // namespace lode::app
