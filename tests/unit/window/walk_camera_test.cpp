#include "client/app/camera/walk_camera.h"

#include <cmath>
#include <memory>

#include <gtest/gtest.h>

namespace lode::app {
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

/// A surface above y = 0, invisible from below.
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

TEST(WalkCamera, walksHorizontallyWhereverItLooks) {
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

TEST(WalkCamera, keepsItsHeightWithoutGround) {
  WalkCamera camera(standingAt({0, 2, 0}), kHeight, kUp);
  walk(camera, {.forward = 1}, 2, [](const glm::dvec3&) { return std::nullopt; });
  EXPECT_NEAR(eyeOf(camera).y, 2, 1e-12);
  EXPECT_LT(eyeOf(camera).z, -5);
}

TEST(WalkCamera, doesNotSinkIntoGroundThatIsOnlyKnownCoarsely) {
  // The camera stands at the true height 0; coarser data give -3 with an uncertainty of 4.
  WalkCamera camera(standingAt({0, 2, 0}), kHeight, kUp);
  walk(camera, {}, 2, flatAt(-3, 4));
  EXPECT_EQ(eyeOf(camera).y, 2);
  // From far above, the camera descends to the highest possible ground.
  WalkCamera high(standingAt({0, 50, 0}), kHeight, kUp);
  walk(high, {}, 3, flatAt(-3, 4));
  EXPECT_NEAR(eyeOf(high).y, 1 + kHeight, 0.01);
  walk(high, {}, 3, flatAt(0));
  EXPECT_NEAR(eyeOf(high).y, 0 + kHeight, 0.01);
}

TEST(WalkCamera, risesWhenHigherGroundArrives) {
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

constexpr double kStep = 1.0 / 1024;
const glm::dvec3 kZ(0, 0, 1);

/// A square of side 1 at a height, with an error.
core::CutPart squareAt(uint32_t z, float error_model = 0) {
  Mesh mesh;
  for (const glm::uvec2 corner : {glm::uvec2(0, 0), {1024, 0}, {1024, 1024}, {0, 1024}})
    mesh.positions.push_back(packPosition({corner.x, corner.y, z}));
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  core::CutPart part;
  part.node = NodeKey{8};
  part.error_model = error_model;
  part.mesh = std::make_shared<const Mesh>(std::move(mesh));
  return part;
}

core::View lookingAside() {
  core::View view;
  view.eye_model = {0.5, 0.5, 1};
  view.forward = {1, 0, 0};
  view.up = kZ;
  return view;
}

core::Cut cutOf(core::CutPart part) {
  core::Cut cut;
  cut.view = lookingAside();
  cut.parts.push_back(std::move(part));
  return cut;
}

std::optional<Ground> below(const core::Cut& cut, const glm::dvec3& point = {0.5, 0.25, 1}) {
  const core::CutProbe probe(std::make_shared<const core::Cut>(cut), kStep);
  return groundBelow(probe, lookingAside(), point, kZ);
}

TEST(GroundBelow, isFoundEvenIfTheCameraLooksElsewhere) {
  const auto ground = below(cutOf(squareAt(256)));
  ASSERT_TRUE(ground);
  EXPECT_DOUBLE_EQ(ground->depth_model, 0.75);
  EXPECT_EQ(ground->uncertainty_model, 0);
}

TEST(GroundBelow, isAbsentBesideAndBelowTheModel) {
  EXPECT_FALSE(below(cutOf(squareAt(256)), {1.5, 0.25, 1}));
  EXPECT_FALSE(below(cutOf(squareAt(256)), {0.5, 0.25, 0.1}));
}

TEST(GroundBelow, isTheFallbackWhereTheCutLeavesANodeOut) {
  core::Cut cut;
  cut.view = lookingAside();
  cut.left_out.push_back({NodeKey{8}, {{0, 0, 0}, {1, 1, 0.5}}});
  core::Fallback fallback;
  fallback.part = squareAt(128);
  fallback.end_left_out = 1;
  cut.fallbacks.push_back(fallback);
  const auto ground = below(cut);
  ASSERT_TRUE(ground);
  EXPECT_DOUBLE_EQ(ground->depth_model, 0.875);
}

TEST(GroundBelow, isAsUncertainAsThePartsErrorInModelUnits) {
  const float error_model = 0.01f;
  const core::Cut cut = cutOf(squareAt(0, error_model));
  const auto ground = below(cut);
  ASSERT_TRUE(ground);
  EXPECT_NEAR(ground->uncertainty_model, error_model, 1e-6);
}

TEST(GroundBelow, isNoMoreUncertainThanTheSizeOfItsPart) {
  const core::Cut cut = cutOf(squareAt(256, 1e9f));
  const auto ground = below(cut);
  ASSERT_TRUE(ground);
  EXPECT_GT(ground->uncertainty_model, 0);
  EXPECT_LT(ground->uncertainty_model, 0.02);
}

}  // namespace

}  // namespace lode::app
