#include "client/app/window/panel/projection.h"

#include <gtest/gtest.h>

#include "client/core/lod/cut_probe.h"

namespace lode::app {
namespace {

core::View slantedView() {
  core::View view;
  view.eye_model = {3, -2, 5};
  view.forward = glm::normalize(glm::dvec3(1, 2, -2));
  view.up = glm::normalize(glm::cross(glm::cross(view.forward, glm::dvec3(0, 1, 0)), view.forward));
  view.width_px = 640;
  view.height_px = 360;
  return view;
}

TEST(Projection, findsAPointOnARayWhereTheRayGoesThrough) {
  const core::View view = slantedView();
  for (const glm::dvec2 place_px :
       {glm::dvec2(0, 0), glm::dvec2(639, 20), glm::dvec2(320, 180), glm::dvec2(-50, 400)}) {
    const core::Ray ray = core::rayThrough(view, place_px);
    const auto found_px = pointInPicture(view, ray.origin_model + 7.0 * ray.direction);
    ASSERT_TRUE(found_px);
    EXPECT_NEAR(glm::distance(*found_px, place_px), 0, 1e-9);
  }
}

TEST(Projection, isEmptyForAPointBehindTheEye) {
  const core::View view = slantedView();
  EXPECT_FALSE(pointInPicture(view, view.eye_model - view.forward));
  EXPECT_FALSE(pointInPicture(view, view.eye_model));
  EXPECT_FALSE(
      lineInPicture(view, view.eye_model - view.forward, view.eye_model - 2.0 * view.forward + view.up));
}

TEST(Projection, clipsASegmentThatPassesTheEye) {
  const core::View view = slantedView();
  const glm::dvec3 front = view.eye_model + 4.0 * view.forward,
                   behind = view.eye_model - view.forward + view.up;
  for (const bool turned : {false, true}) {
    const auto line = turned ? lineInPicture(view, behind, front) : lineInPicture(view, front, behind);
    ASSERT_TRUE(line);
    const glm::dvec2 seen_px = turned ? line->to_px : line->from_px,
                     cut_px = turned ? line->from_px : line->to_px;
    EXPECT_NEAR(glm::distance(seen_px, glm::dvec2(320, 180)), 0, 1e-9);
    EXPECT_NEAR(cut_px.x, 320, 1e-6);
    EXPECT_LT(cut_px.y, 0) << "upwards, out of the picture";
  }
}

}  // namespace
}  // namespace lode::app
