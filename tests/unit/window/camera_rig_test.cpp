#include "client/app/camera/camera_rig.h"

#include <gtest/gtest.h>

#include "client/app/window/panel/projection.h"

namespace lode::app {
namespace {

/// A model of 1024 × 1024 × 512 steps of 1, with z up.
ModelSummary someModel() {
  ModelSummary model;
  model.lattice.step = 1;
  model.box.add({0, 0, 0});
  model.box.add({1024, 1024, 512});
  return model;
}

core::Framing zUp() {
  core::Framing framing;
  framing.up = glm::dvec3(0, 0, 1);
  return framing;
}

/// A horizontal plane at a height.
GroundBelow plainAt(double z) {
  return [z](const glm::dvec3& point) -> std::optional<Ground> {
    if (point.z < z) return std::nullopt;
    return Ground{point.z - z, 0};
  };
}

Input tab() {
  Input input;
  input.next_camera = 1;
  return input;
}

TEST(CameraRig, orbitsAboutAModelFramedBesideThePanel) {
  const ModelSummary model = someModel();
  core::Framing framing = zUp();
  framing.covered = 0.3;
  CameraRig rig(model, framing, std::nullopt, 800, 600);
  const glm::dvec3 middle(512, 512, 256);
  const double distance = glm::distance(rig.view().eye_model, middle);
  const glm::dvec3 to_middle = glm::normalize(middle - rig.view().eye_model);
  EXPECT_LT(glm::dot(rig.view().forward, to_middle), 0.99) << "it is not straight ahead";
  Input input;
  input.turned_px = {150, 0};
  rig.apply(input, 0.016, plainAt(0));
  EXPECT_NEAR(glm::distance(rig.view().eye_model, middle), distance, 1e-6 * distance);
}

TEST(CameraRig, reframesTheFirstViewWhenThePanelIsHidden) {
  const ModelSummary model = someModel();
  core::Framing framing = zUp();
  framing.covered = 0.3;
  CameraRig rig(model, framing, std::nullopt, 800, 600);
  const core::View beside = rig.view();
  Input input;
  input.reset_camera = true;
  rig.frameBeside(0);
  rig.apply(input, 0.016, plainAt(0));
  EXPECT_EQ(rig.view(), CameraRig(model, zUp(), std::nullopt, 800, 600).view());
  EXPECT_NE(rig.view(), beside);
}

Input parallel() {
  Input input;
  input.toggle_parallel = true;
  return input;
}

TEST(CameraRig, keepsTheFieldOfViewWhileItIsHeld) {
  const ModelSummary model = someModel();
  for (const bool is_parallel : {false, true}) {
    CameraRig rig(model, zUp(), std::nullopt, 800, 600);
    const core::View perspective = rig.view();
    Input bookmark;
    bookmark.bookmark = 1;
    bookmark.set_bookmark = true;
    if (!is_parallel) rig.apply(parallel(), 0.016, plainAt(0));
    rig.apply(bookmark, 0.016, plainAt(0));
    rig.apply(parallel(), 0.016, plainAt(0));
    rig.holdFieldOfView(true);
    const double held_rad = rig.view().fov_y_rad;
    bookmark.set_bookmark = false;
    Input reset, up, side;
    reset.reset_camera = true;
    up.next_axis = 1;
    side.side = core::Side::kTop;
    for (const Input& input : {bookmark, tab(), up, side, reset}) {
      rig.apply(input, 0.016, plainAt(0));
      EXPECT_EQ(rig.view().fov_y_rad, held_rad);
    }
    EXPECT_TRUE(!is_parallel || rig.kind() == CameraKind::kOrbit);
    rig.holdFieldOfView(false);
    rig.apply(reset, 0.016, plainAt(0));
    EXPECT_EQ(rig.view().fov_y_rad, perspective.fov_y_rad);
  }
}

TEST(CameraRig, keepsThePictureOfTheFirstViewWhileItsFieldOfViewIsHeld) {
  const ModelSummary model = someModel();
  CameraRig rig(model, zUp(), std::nullopt, 800, 600);
  const core::View first = rig.view();
  const glm::dvec3 point = first.eye_model + first.forward * rig.distanceModel() + first.up * 100.0;
  const auto before = pointInPicture(first, point);
  rig.apply(parallel(), 0.016, plainAt(0));
  rig.holdFieldOfView(true);
  Input reset;
  reset.reset_camera = true;
  rig.apply(reset, 0.016, plainAt(0));
  EXPECT_LT(glm::distance(*pointInPicture(rig.view(), point), *before), 1e-6);
}

TEST(CameraRig, keepsThePictureOfTheOrbitedPlaneInParallelProjection) {
  const ModelSummary model = someModel();
  CameraRig rig(model, zUp(), std::nullopt, 800, 600);
  const glm::dvec3 pivot(400, 500, 300);
  rig.turnAbout(pivot);
  const core::View before = rig.view();
  const glm::dvec3 right = glm::cross(before.forward, before.up);
  rig.apply(parallel(), 0.016, plainAt(0));
  EXPECT_TRUE(rig.isParallel());
  for (const glm::dvec3& point : {pivot, pivot + 100.0 * right, pivot - 150.0 * before.up})
    EXPECT_LT(glm::distance(*pointInPicture(before, point), *pointInPicture(rig.view(), point)), 1e-6);
  rig.apply(parallel(), 0.016, plainAt(0));
  EXPECT_FALSE(rig.isParallel());
  EXPECT_LT(glm::distance(rig.view().eye_model, before.eye_model), 1e-6);
}

TEST(CameraRig, showsDepthsAndErrorsAlikeInParallelProjection) {
  const ModelSummary model = someModel();
  CameraRig rig(model, zUp(), std::nullopt, 800, 600);
  rig.apply(parallel(), 0.016, plainAt(0));
  const core::View& view = rig.view();
  const glm::dvec3 middle(512, 512, 256), aside = glm::cross(view.forward, view.up) * 300.0;
  const auto error_px = [&](const glm::dvec3& point) {
    return core::screenErrorPx(1, core::distanceToBox(view.eye_model, {point, point}), view);
  };
  for (const double depth : {-500.0, 500.0}) {
    const glm::dvec3 point = middle + aside + depth * view.forward;
    EXPECT_LT(glm::distance(*pointInPicture(view, point), *pointInPicture(view, middle + aside)), 1);
    EXPECT_NEAR(error_px(point), error_px(middle), 2e-3 * error_px(middle));
  }
  const double unit_px =
      glm::distance(*pointInPicture(view, middle + aside), *pointInPicture(view, middle)) / 300;
  EXPECT_NEAR(error_px(middle), unit_px, 1e-3 * unit_px) << "an error of 1 is as large as a length of 1";
}

TEST(CameraRig, looksAtSidesInItsProjectionAndFliesInPerspective) {
  const ModelSummary model = someModel();
  CameraRig rig(model, zUp(), std::nullopt, 800, 600);
  rig.apply(parallel(), 0.016, plainAt(0));
  Input side;
  side.side = core::Side::kTop;
  rig.apply(side, 0.016, plainAt(0));
  EXPECT_TRUE(rig.isParallel());
  EXPECT_LT(glm::distance(rig.view().forward, glm::dvec3(0, 0, -1)), 1e-9);
  const glm::dvec2 corner = *pointInPicture(rig.view(), {0, 1024, 512});
  EXPECT_TRUE(corner.x > 0 && corner.y > 0 && corner.x < 400 && corner.y < 60)
      << corner.x << ", " << corner.y;
  rig.apply(tab(), 0.016, plainAt(0));
  EXPECT_EQ(rig.kind(), CameraKind::kFly);
  EXPECT_FALSE(rig.isParallel());
}

/// A slow frame may contain several key presses.
TEST(CameraRig, advancesOneCameraKindPerTabWithinAFrame) {
  const ModelSummary model = someModel();
  CameraRig rig(model, zUp(), std::nullopt, 800, 600);
  Input input = tab();
  input.next_camera = 2;
  rig.apply(input, 0.016, plainAt(0));
  EXPECT_EQ(rig.kind(), CameraKind::kWalk);
}

/// Distance flown in a tenth of a second.
double flownBy(CameraRig& rig) {
  const glm::dvec3 from = rig.view().eye_model;
  Input input;
  input.fly.forward = 1;
  rig.apply(input, 0.1, plainAt(0));
  return glm::distance(rig.view().eye_model, from);
}

TEST(CameraRig, adaptsItsSpeedToAGrownModel) {
  ModelSummary model = someModel();
  CameraRig rig(model, zUp(), std::nullopt, 800, 600);
  rig.apply(tab(), 0.016, plainAt(0));
  const double flown = flownBy(rig);
  EXPECT_GT(flown, 0);
  model.box.add({10240, 10240, 5120});
  Input again;
  again.reset_camera = true;
  rig.apply(again, 0.016, plainAt(0));
  EXPECT_NEAR(flownBy(rig), 10 * flown, 1e-6 * flown);
}

TEST(CameraRig, goesFromOrbitToFlyToWalkAndBackWithoutMovingAtOnce) {
  const ModelSummary model = someModel();
  CameraRig rig(model, zUp(), std::nullopt, 800, 600);
  const auto nowhere = [](const glm::dvec3&) { return std::optional<Ground>(); };
  for (const CameraKind next : {CameraKind::kFly, CameraKind::kWalk, CameraKind::kOrbit}) {
    const core::View before = rig.view();
    rig.apply(tab(), 0.01, nowhere);
    EXPECT_EQ(rig.kind(), next);
    EXPECT_LT(glm::distance(rig.view().eye_model, before.eye_model), 1e-6);
    EXPECT_GT(glm::dot(rig.view().forward, before.forward), 1 - 1e-9);
  }
}

TEST(CameraRig, walksFromItsGivenPlaceLookingAhead) {
  const ModelSummary model = someModel();
  CameraRig rig(model, zUp(), std::nullopt, 800, 600);
  rig.apply(tab(), 0.01, plainAt(100));
  rig.apply(tab(), 0.01, plainAt(100));
  ASSERT_EQ(rig.kind(), CameraKind::kWalk);
  rig.standAt({300, 400, 100});
  for (int frame = 0; frame < 200; ++frame) rig.apply({}, 0.02, plainAt(100));
  EXPECT_FALSE(rig.isMoving());
  EXPECT_NEAR(rig.view().eye_model.x, 300, 1e-6);
  EXPECT_NEAR(rig.view().eye_model.y, 400, 1e-6);
  EXPECT_GT(rig.view().eye_model.z, 105);
  EXPECT_LT(rig.view().eye_model.z, 115);
  EXPECT_NEAR(rig.view().forward.z, 0, 1e-9);
}

TEST(CameraRig, knowsWhichBookmarksAreSet) {
  const ModelSummary model = someModel();
  CameraRig rig(model, zUp(), std::nullopt, 800, 600);
  Input input;
  input.bookmark = 3;
  rig.apply(input, 0.01, plainAt(100));
  EXPECT_FALSE(rig.hasBookmark(3));
  input.set_bookmark = true;
  rig.apply(input, 0.01, plainAt(100));
  EXPECT_TRUE(rig.hasBookmark(3));
  EXPECT_FALSE(rig.hasBookmark(2));
}

/// A path of one camera whose up differs much from the model's.
core::CameraPath steepPath() {
  core::CameraPath path;
  path.keys.push_back({0, {300, -300, 3000}, {300, 200, 0}, {300, 950, 0}});
  return path;
}

TEST(CameraRig, orbitsAboutTheModelsUpAxisNotThePathCameras) {
  const ModelSummary model = someModel();
  CameraRig rig(model, zUp(), steepPath(), 800, 600);
  EXPECT_EQ(rig.up(), glm::dvec3(0, 0, 1));
  Input drag;
  drag.turned_px = {40, 0};
  const double height = rig.view().eye_model.z;
  rig.apply(drag, 0.01, plainAt(100));
  EXPECT_NEAR(rig.view().eye_model.z, height, 1e-9);
}

TEST(CameraRig, showsAPathsFirstCameraAsItIsUntilItIsMoved) {
  const ModelSummary model = someModel();
  const core::CameraPath path = steepPath();
  CameraRig rig(model, zUp(), path, 800, 600);
  const core::View wanted = core::toView(path.keys.front(), path.fov_y_deg, 800, 600, model);
  rig.apply({}, 0.01, plainAt(100));
  EXPECT_EQ(rig.view(), wanted);
  Input input;
  input.fly.forward = 1;
  rig.apply(input, 0.1, plainAt(100));
  EXPECT_NE(rig.view(), wanted);
  input = {};
  input.reset_camera = true;
  rig.apply(input, 0.1, plainAt(100));
  EXPECT_EQ(rig.view(), wanted);
}

TEST(CameraRig, orbitsFromStraightAboveWithoutRollingThePicture) {
  const ModelSummary model = someModel();
  core::CameraPath path;
  path.keys.push_back({0, {512, 512, 3000}, {512, 512, 0}, {0, 1, 0}});
  CameraRig rig(model, zUp(), path, 800, 600);
  Input drag;
  drag.turned_px = {0, 1};
  rig.apply(drag, 0.01, plainAt(100));
  EXPECT_GT(rig.view().up.y, 0.99);
}

TEST(CameraRig, doesNotMoveWhenItGetsANewPivot) {
  const ModelSummary model = someModel();
  CameraRig rig(model, zUp(), std::nullopt, 800, 600);
  Input drag;
  drag.turned_px = {37, 11};
  rig.apply(drag, 0.01, plainAt(100));
  const core::View before = rig.view();
  rig.turnAbout({123.4, 567.8, 90.1});
  rig.apply({}, 0.01, plainAt(100));
  EXPECT_EQ(rig.view(), before);
}

TEST(CameraRig, reportsItsCameraWithTheModelsUpAxis) {
  const ModelSummary model = someModel();
  CameraRig rig(model, zUp(), std::nullopt, 800, 600);
  Input drag;
  drag.turned_px = {0, 150};
  rig.apply(drag, 0.01, plainAt(100));
  const core::CameraKey camera = rig.camera();
  EXPECT_EQ(camera.up, glm::dvec3(0, 0, 1));
  const core::View told = core::toView(camera, 45, 800, 600, model);
  EXPECT_LT(glm::distance(told.up, rig.view().up), 1e-9);
  EXPECT_LT(glm::distance(told.forward, rig.view().forward), 1e-9);
}

TEST(CameraRig, reportsTheRollOfATiltedCamera) {
  const ModelSummary model = someModel();
  const CameraRig rig(model, zUp(), steepPath(), 800, 600);
  const core::View told = core::toView(rig.camera(), 45, 800, 600, model);
  EXPECT_LT(glm::distance(told.up, rig.view().up), 1e-9);
}

TEST(CameraRig, reportsAnUpsideDownCamera) {
  const ModelSummary model = someModel();
  const CameraRig upright(model, zUp(), std::nullopt, 800, 600);
  core::CameraPath path{45, {upright.camera()}};
  path.keys[0].up = {0, 0, -1};
  const CameraRig rig(model, zUp(), path, 800, 600);
  const core::View told = core::toView(rig.camera(), 45, 800, 600, model);
  EXPECT_LT(glm::distance(told.up, rig.view().up), 1e-9);
}

TEST(CameraRig, goesToABookmarkWithTheCameraThatItWasSetWith) {
  const ModelSummary model = someModel();
  CameraRig rig(model, zUp(), std::nullopt, 800, 600);
  Input input;
  input.bookmark = 1;
  input.set_bookmark = true;
  rig.apply(input, 0.01, plainAt(100));
  const core::View set = rig.view();
  rig.apply(tab(), 0.01, plainAt(100));
  rig.apply(tab(), 0.01, plainAt(100));
  ASSERT_EQ(rig.kind(), CameraKind::kWalk);
  input.set_bookmark = false;
  rig.apply(input, 0.5, plainAt(100));
  EXPECT_EQ(rig.kind(), CameraKind::kOrbit);
  EXPECT_EQ(rig.view(), set);
}

TEST(CameraRig, reframesTheModelForTheCurrentWindowSize) {
  const ModelSummary model = someModel();
  CameraRig rig(model, zUp(), std::nullopt, 800, 600);
  const double near_model = rig.camera().eye.z;
  rig.resize(200, 600);
  Input input;
  input.reset_camera = true;
  rig.apply(input, 0.01, plainAt(100));
  EXPECT_GT(rig.camera().eye.z, 2 * near_model);
}

TEST(CameraRig, ignoresAPlaceToStandUnlessItWalks) {
  const ModelSummary model = someModel();
  CameraRig rig(model, zUp(), std::nullopt, 800, 600);
  const core::View before = rig.view();
  rig.standAt({300, 400, 100});
  rig.apply({}, 0.01, plainAt(100));
  EXPECT_LT(glm::distance(rig.view().eye_model, before.eye_model), 1e-9);
}

}  // namespace
}  // namespace lode::app
