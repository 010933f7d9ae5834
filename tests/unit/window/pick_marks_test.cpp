#include "client/app/window/pick_marks.h"

#include <gtest/gtest.h>

namespace lode::app {
namespace {

PickedPoint pointAt(glm::dvec3 position_model) {
  PickedPoint point;
  point.position_model = position_model;
  point.position = glm::dvec3(100) + position_model;
  return point;
}

core::View alongMinusZ() {
  core::View view;
  view.eye_model = {0, 0, 1};
  view.width_px = 200;
  view.height_px = 100;
  return view;
}

TEST(PickMarks, joinTheTwoPointsByALineThatSaysHowLongItIs) {
  Picks picks;
  picks.add(pointAt({0, 0, 0}));
  EXPECT_FALSE(marksOf(picks, alongMinusZ()).line);
  picks.add(pointAt({3, 0, 0}));
  const PickMarks marks = marksOf(picks, alongMinusZ());
  ASSERT_TRUE(marks.line);
  ASSERT_EQ(marks.points_px.size(), 2u);
  EXPECT_EQ(marks.points_px[0], glm::dvec2(100, 50)) << "in the model's frame, not at true coordinates";
  EXPECT_EQ(marks.line->from_px, marks.points_px[0]);
  EXPECT_EQ(marks.line->to_px, marks.points_px[1]);
  EXPECT_EQ(marks.distance, "3");
}

TEST(PickMarks, areNotAtAPointBehindTheEye) {
  Picks picks;
  picks.add(pointAt({0, 0, 0}));
  picks.add(pointAt({0, 0, 2}));
  const PickMarks marks = marksOf(picks, alongMinusZ());
  EXPECT_EQ(marks.points_px.size(), 1u);
  EXPECT_TRUE(marks.line);
}

}  // namespace
}  // namespace lode::app
