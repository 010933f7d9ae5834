#include "client/app/window/camera/walk_camera.h"

#include <cmath>

#include <gtest/gtest.h>

namespace lode::render {
namespace {

const glm::dvec3 kUp(0, 1, 0);
constexpr double kHeight = 2;
constexpr double kFrameS = 1.0 / 60;

core::View standingAt(const glm::dvec3& eye) {
  core::View view;
  view.eye_model = eye;
  view.forward = {0, 0, -1};
  view.up = kUp;
  view.width_px = 800;
  view.height_px = 600;
  return view;
}

/// A surface above y = 0, of which nothing is seen from below.
template <typename Height>
GroundBelow groundOf(Height height, double uncertainty_model = 0) {
  return [=](const glm::dvec3& point) -> std::optional<Ground> {
    const double depth = point.y - height(point);
    if (depth < 0) return std::nullopt;
    return Ground{depth, uncertainty_model};
  };
}

GroundBelow flatAt(double y, double uncertainty_model = 0) {
  return groundOf([y](const glm::dvec3&) { return y; }, uncertainty_model);
}

glm::dvec3 eyeOf(const WalkCamera& camera) {
  core::View view;
  camera.apply(view);
  return view.eye_model;
}

void walk(WalkCamera& camera, const FlyKeys& keys, double seconds, const GroundBelow& ground) {
  for (double t = 0; t < seconds; t += kFrameS) camera.move(keys, kFrameS, ground);
}

TEST(WalkCamera, comesDownToItsHeightAboveTheGroundSmoothly) {
  WalkCamera camera(standingAt({3, 10, 4}), kHeight, kUp);
  double before = 10;
  for (int frame = 0; frame < 120; ++frame) {
    camera.move({}, kFrameS, flatAt(1));
    const double now = eyeOf(camera).y;
    EXPECT_LE(now, before);
    EXPECT_LT(before - now, 1) << "no jump";
    before = now;
  }
  EXPECT_NEAR(before, 3, 0.01);
  EXPECT_FALSE(camera.isSettling());
  EXPECT_EQ(eyeOf(camera).x, 3);
  camera.move({}, kFrameS, flatAt(1));
  EXPECT_EQ(eyeOf(camera).y, before) << "a view that creeps on is drawn for ever";
}

TEST(WalkCamera, walksOnTheLevelWhereverItLooks) {
  WalkCamera camera(standingAt({0, 2, 0}), kHeight, kUp);
  camera.look({0, 500}, standingAt({}));  // up or down
  walk(camera, {.forward = 1}, 1, flatAt(0));
  EXPECT_NEAR(eyeOf(camera).y, 2, 1e-9);
  EXPECT_NEAR(eyeOf(camera).x, 0, 1e-9);
  EXPECT_NEAR(eyeOf(camera).z, -2.5 * kHeight, 0.2);
}

TEST(WalkCamera, staysAboveASlopeHoweverFastItWalksUp) {
  const auto slope = [](const glm::dvec3& point) { return std::max(0.0, -point.z); };
  for (const bool fast : {false, true}) {
    WalkCamera camera(standingAt({0, 2, 0}), kHeight, kUp);
    for (int frame = 0; frame < 30; ++frame) {
      camera.move({.forward = 1, .fast = fast}, 0.1, groundOf(slope));
      EXPECT_GE(eyeOf(camera).y - slope(eyeOf(camera)), kHeight / 4 - 1e-9);
    }
    EXPECT_LT(eyeOf(camera).z, -10);
  }
}

TEST(WalkCamera, staysAsHighAsItIsWhereThereIsNoGround) {
  WalkCamera camera(standingAt({0, 2, 0}), kHeight, kUp);
  walk(camera, {.forward = 1}, 2, [](const glm::dvec3&) { return std::nullopt; });
  EXPECT_NEAR(eyeOf(camera).y, 2, 1e-12);
  EXPECT_LT(eyeOf(camera).z, -5);
}

TEST(WalkCamera, doesNotSinkIntoGroundThatIsOnlyKnownCoarsely) {
  // It stands on what is really at 0, and coarser data say -3, give or take 4.
  WalkCamera camera(standingAt({0, 2, 0}), kHeight, kUp);
  walk(camera, {}, 2, flatAt(-3, 4));
  EXPECT_EQ(eyeOf(camera).y, 2);
  // From afar it comes down to where the ground may be at most.
  WalkCamera high(standingAt({0, 50, 0}), kHeight, kUp);
  walk(high, {}, 3, flatAt(-3, 4));
  EXPECT_NEAR(eyeOf(high).y, 1 + kHeight, 0.01);
  walk(high, {}, 3, flatAt(0));
  EXPECT_NEAR(eyeOf(high).y, 0 + kHeight, 0.01);
}

TEST(WalkCamera, isLiftedByGroundThatComesInHigher) {
  WalkCamera camera(standingAt({0, 2, 0}), kHeight, kUp);
  walk(camera, {}, 1, flatAt(1.5));
  EXPECT_NEAR(eyeOf(camera).y, 3.5, 0.01);
}

TEST(WalkCamera, passesUnderACeilingThatIsHigherThanItLooksUp) {
  const auto cave = [](const glm::dvec3& point) -> std::optional<Ground> {
    const double top = point.y >= 6 ? 6 : 0;
    return Ground{point.y - top, 0};
  };
  WalkCamera camera(standingAt({0, 2, 0}), kHeight, kUp);
  walk(camera, {.forward = 1}, 1, cave);
  EXPECT_NEAR(eyeOf(camera).y, 2, 1e-9);
}

TEST(WalkCamera, growsAndShrinksByKeysAndItsSpeedWithIt) {
  WalkCamera camera(standingAt({0, 2, 0}), kHeight, kUp);
  walk(camera, {.up = 1}, 1, flatAt(0));
  EXPECT_NEAR(camera.eyeHeightModel(), 2 * kHeight, 0.1);
  walk(camera, {}, 2, flatAt(0));
  EXPECT_NEAR(eyeOf(camera).y, camera.eyeHeightModel(), 0.01);
  const double start = eyeOf(camera).z;
  walk(camera, {.forward = 1}, 1, flatAt(0));
  EXPECT_NEAR(start - eyeOf(camera).z, 2.5 * camera.eyeHeightModel(), 0.3);
}

}  // namespace
}  // namespace lode::render
