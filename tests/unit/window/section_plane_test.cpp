#include "client/app/window/section_plane.h"

#include <gtest/gtest.h>

namespace lode::app {
namespace {

const core::ModelBox kCutBox{{0, -2, 10}, {4, 2, 30}};

core::View sectionView() {
  core::View view;
  view.eye_model = {2, 0, 60};
  view.width_px = 800;
  view.height_px = 600;
  return view;
}

TEST(SectionPlane, stepsThroughTheAxesInTheMiddleOfTheBox) {
  SectionPlane plane;
  EXPECT_FALSE(plane.in(kCutBox));
  for (int axis = 0; axis < 3; ++axis) {
    plane.step();
    const auto section = plane.in(kCutBox);
    ASSERT_TRUE(section);
    EXPECT_EQ(section->normal[axis], 1);
    EXPECT_EQ(section->offset_model, (kCutBox.min[axis] + kCutBox.max[axis]) / 2);
  }
  plane.step();
  EXPECT_FALSE(plane.in(kCutBox));
}

TEST(SectionPlane, followsThePointerWithinTheBox) {
  SectionPlane plane;
  plane.step();
  const core::View view = sectionView();
  const double unit_px = core::focalPx(view) / 40;
  plane.drag({unit_px, 50}, view, 40, kCutBox);
  EXPECT_NEAR(plane.in(kCutBox)->offset_model, 3, 1e-9);
  plane.drag({50 * unit_px, 0}, view, 40, kCutBox);
  EXPECT_EQ(plane.in(kCutBox)->offset_model, 4);
}

TEST(SectionPlane, movesAwayFromTheViewerByAnUpwardDrag) {
  SectionPlane plane;
  for (int axis = 0; axis < 3; ++axis) plane.step();
  plane.drag({0, -30}, sectionView(), 40, kCutBox);
  EXPECT_LT(plane.in(kCutBox)->offset_model, 20);
}

TEST(SectionPlane, showsTheOtherHalfWhenItIsFlipped) {
  SectionPlane plane;
  plane.step();
  const auto before = plane.in(kCutBox);
  plane.flip();
  EXPECT_EQ(plane.in(kCutBox)->normal, -before->normal);
  EXPECT_EQ(plane.in(kCutBox)->offset_model, -before->offset_model);
}

TEST(SectionPlane, cutsRaysToTheShownSide) {
  const render::Section section{{1, 0, 0}, 2};
  const auto into = shownRay({5, 1, 0}, {-1, 0, 0}, section);
  ASSERT_TRUE(into);
  EXPECT_EQ(into->origin_model, glm::dvec3(2, 1, 0));
  EXPECT_TRUE(into->begins_in_cut);
  EXPECT_FALSE(shownRay({5, 1, 0}, {1, 0, 0}, section));
  const auto out = shownRay({0, 0, 0}, {1, 0, 0}, section);
  ASSERT_TRUE(out);
  EXPECT_EQ(out->most_model, 2);
  EXPECT_FALSE(out->begins_in_cut);
}

}  // namespace
}  // namespace lode::app
