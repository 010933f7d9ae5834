#include "client/app/window/panel/pick_marks.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "client/app/window/scene/picks.h"

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
  EXPECT_TRUE(marksOf(picks.current(), {0, 1, 0}, "m", alongMinusZ()).lines.empty());
  picks.add(pointAt({3, 0, 0}));
  const PickMarks marks = marksOf(picks.current(), {0, 1, 0}, "m", alongMinusZ());
  ASSERT_EQ(marks.lines.size(), 1u);
  ASSERT_EQ(marks.points_px.size(), 2u);
  EXPECT_EQ(marks.points_px[0], glm::dvec2(100, 50)) << "in the model's frame, not at true coordinates";
  EXPECT_EQ(marks.lines[0].from_px, marks.points_px[0]);
  EXPECT_EQ(marks.lines[0].to_px, marks.points_px[1]);
  EXPECT_EQ(marks.value, "3 \u00b1 2 m");
}

/// All corners of the text must be on one side of the line, the nearest at the distance of the gap.
TEST(PickMarks, haveTheirTextBesideAShortOrSteepLine) {
  const glm::dvec2 text(60, 16), window(800, 600);
  for (const glm::dvec2 to :
       {glm::dvec2(410, 300), {400, 310}, {420, 280}, {300, 200}, {700, 310}, {400, 300}}) {
    const PictureLine line{{400, 300}, to};
    const glm::dvec2 corner = besideLine(line, text, window, 5), along = to - line.from_px;
    const glm::dvec2 across =
        along == glm::dvec2(0) ? glm::dvec2(0, 1) : glm::normalize(glm::dvec2(-along.y, along.x));
    double nearest = 1e9;
    for (const glm::dvec2 of : {glm::dvec2(0), glm::dvec2(text.x, 0), glm::dvec2(0, text.y), text}) {
      nearest = std::min(nearest, glm::dot(corner + of - line.from_px, across) * (across.y < 0 ? -1 : 1));
    }
    EXPECT_NEAR(nearest, 5, 1e-9) << to.x << ", " << to.y;
  }
}

TEST(PickMarks, haveTheirTextInTheWindowWhereTheLineEndsBeyondIt) {
  const glm::dvec2 text(60, 16), window(800, 600);
  for (const glm::dvec2 to : {glm::dvec2(5000, 300), {-5000, -3000}, {400, 9000}}) {
    const glm::dvec2 corner = besideLine({{400, 300}, to}, text, window, 5);
    EXPECT_TRUE(corner.x >= 5 && corner.y >= 5 && corner.x <= 735 && corner.y <= 579)
        << corner.x << ", " << corner.y;
  }
}

TEST(PickMarks, areNotAtAPointBehindTheEye) {
  Picks picks;
  picks.add(pointAt({0, 0, 0}));
  picks.add(pointAt({0, 0, 2}));
  const PickMarks marks = marksOf(picks.current(), {0, 1, 0}, "m", alongMinusZ());
  EXPECT_EQ(marks.points_px.size(), 1u);
  EXPECT_EQ(marks.lines.size(), 1u);
}

}  // namespace
}  // namespace lode::app
