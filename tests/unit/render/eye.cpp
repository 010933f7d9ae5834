#include "client/render/gl/eye.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace lode::render {
namespace {

TEST(SplitEye, losesNothingOfTheEye) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> anywhere(-3e6, 3e6);
  for (int i = 0; i < 1000; ++i) {
    const glm::dvec3 eye(anywhere(random), anywhere(random), anywhere(random));
    const SplitEye split = splitEye(eye, 0.5);
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_LE(std::abs(split.low[axis]), 0.5f);
      EXPECT_NEAR((split.high[axis] + double(split.low[axis])) * 0.5, eye[axis], 3e-8);
    }
  }
}

TEST(SplitEye, staysFiniteForAnEyeFarOutside) {
  const SplitEye split = splitEye({1e15, -1e15, 0}, 1e-3);
  EXPECT_EQ(split.high.x, 1 << 30);
  EXPECT_EQ(split.high.y, -(1 << 30));
  EXPECT_TRUE(std::isfinite(split.low.x));
}

TEST(ViewRotation, bringsForwardToMinusZAndUpToY) {
  core::View view;
  view.forward = glm::normalize(glm::dvec3(1, 2, -2));
  view.up = glm::normalize(glm::cross(glm::cross(view.forward, {0, 1, 0}), view.forward));
  const glm::mat3 rotation = viewRotation(view);
  EXPECT_NEAR(glm::distance(rotation * glm::vec3(view.forward), glm::vec3(0, 0, -1)), 0, 1e-6);
  EXPECT_NEAR(glm::distance(rotation * glm::vec3(view.up), glm::vec3(0, 1, 0)), 0, 1e-6);
  EXPECT_NEAR(glm::determinant(rotation), 1, 1e-6);
}

TEST(ReversedProjection, putsTheFieldOfViewOnTheUpperEdge) {
  core::View view;
  view.fov_y_rad = 1;
  view.width_px = 200;
  view.height_px = 100;
  const Projection projection = reversedProjection(view, 1e-3);
  EXPECT_NEAR(projection.scale.y * std::tan(0.5), 1, 1e-6);
  EXPECT_NEAR(projection.scale.x * 2, projection.scale.y, 1e-6);
}

TEST(ReversedProjection, keepsTheNearPlaneALatticeStepAway) {
  core::View view;
  view.near_model = 1e-9;
  EXPECT_FLOAT_EQ(reversedProjection(view, 0.25).near_model, 0.25f);
}

}  // namespace
}  // namespace lode::render
