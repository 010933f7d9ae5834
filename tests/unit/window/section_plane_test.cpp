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
  EXPECT_FALSE(plane.section());
  for (int axis = 0; axis < 3; ++axis) {
    plane.step(kCutBox);
    const auto section = plane.section();
    ASSERT_TRUE(section);
    EXPECT_EQ(section->normal[axis], 1);
    EXPECT_EQ(section->offset_model, (kCutBox.min[axis] + kCutBox.max[axis]) / 2);
  }
  plane.step(kCutBox);
  EXPECT_FALSE(plane.section());
}

TEST(SectionPlane, followsThePointerWithinTheBox) {
  SectionPlane plane;
  plane.step(kCutBox);
  const core::View view = sectionView();
  const double unit_px = core::focalPx(view) / 40;
  plane.drag({unit_px, 50}, view, 40, kCutBox);
  EXPECT_NEAR(plane.section()->offset_model, 3, 1e-9);
  plane.drag({50 * unit_px, 0}, view, 40, kCutBox);
  EXPECT_EQ(plane.section()->offset_model, 4);
}

TEST(SectionPlane, staysInPlaceWhenTheBoxChanges) {
  SectionPlane plane;
  plane.step(kCutBox);
  const core::ModelBox of_the_rest{{3, -2, 10}, {4, 2, 30}};
  plane.drag({0, 0}, sectionView(), 40, of_the_rest);
  EXPECT_EQ(plane.section()->offset_model, 2);
  plane.flip();
  EXPECT_EQ(plane.section()->offset_model, -2);
  plane.drag({1, 0}, sectionView(), 40, of_the_rest);
  EXPECT_EQ(plane.section()->offset_model, -3);
}

TEST(SectionPlane, isDescribedByItsPlaceInTheBox) {
  SectionPlane plane;
  EXPECT_EQ(plane.describe(kCutBox), "no section");
  plane.step(kCutBox);
  EXPECT_EQ(plane.describe(kCutBox), "section across x at 50 %");
  EXPECT_EQ(plane.describe({{0, -2, 10}, {8, 2, 30}}), "section across x at 25 %");
}

TEST(SectionPlane, movesAwayFromTheViewerByAnUpwardDrag) {
  SectionPlane plane;
  for (int axis = 0; axis < 3; ++axis) plane.step(kCutBox);
  plane.drag({0, -30}, sectionView(), 40, kCutBox);
  EXPECT_LT(plane.section()->offset_model, 20);
}

TEST(SectionPlane, showsTheOtherHalfWhenItIsFlipped) {
  SectionPlane plane;
  plane.step(kCutBox);
  const auto before = plane.section();
  plane.flip();
  EXPECT_EQ(plane.section()->normal, -before->normal);
  EXPECT_EQ(plane.section()->offset_model, -before->offset_model);
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
