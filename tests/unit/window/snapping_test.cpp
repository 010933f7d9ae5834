#include "client/app/window/scene/snapping.h"

#include <gtest/gtest.h>

namespace lode::app {
namespace {

/// Returns a point on a surface that faces +z, seen from above at a slant.
PickedPoint coarsePoint() {
  PickedPoint point;
  point.step = 1e-6;
  point.error = 0.1;
  point.normal = {0, 0, 1};
  point.position_model = glm::dvec3(0);
  point.seen_along = {{-10, 0, 10}, glm::normalize(glm::dvec3(1, 0, -1))};
  return point;
}

PickedPoint finerAt(glm::dvec3 position_model) {
  PickedPoint point = coarsePoint();
  point.error = 0.01;
  point.position_model = position_model;
  return point;
}

TEST(Snapping, acceptsAPointWithinTheErrorsOfBothSurfaces) {
  const PickedPoint coarse = coarsePoint();
  EXPECT_TRUE(isSamePlace(coarse, coarse.seen_along, finerAt({0.1, 0, -0.1})))
      << "0.1 below, but 0.14 along the slanting ray";
  EXPECT_FALSE(isSamePlace(coarse, coarse.seen_along, finerAt({0.3, 0, -0.3}))) << "another surface behind";
  EXPECT_FALSE(isSamePlace(coarse, snappingRays(coarse)[1], finerAt({0.1, 0, -0.1})));
}

TEST(Snapping, looksAlongTheNormalFromBeyondBothErrors) {
  const PickedPoint coarse = coarsePoint();
  const auto rays = snappingRays(coarse);
  EXPECT_EQ(rays[0].origin_model, coarse.seen_along.origin_model);
  for (const core::Ray& ray : {rays[1], rays[2]}) {
    EXPECT_GE(glm::distance(ray.origin_model, coarse.position_model), 0.2);
    EXPECT_LT(glm::dot(ray.direction, ray.origin_model), 0) << "towards the point";
  }
}

}  // namespace
}  // namespace lode::app
