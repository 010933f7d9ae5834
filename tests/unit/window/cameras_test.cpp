#include "client/app/camera/cameras.h"

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "tests/unit/render/silhouette.h"

namespace lode::app {
namespace {

using test::projectTo;

const glm::dvec3 kY(0, 1, 0);

core::View startView() {
  core::View view;
  view.eye_model = {0, 0, 10};
  view.forward = {0, 0, -1};
  view.up = {0, 1, 0};
  view.width_px = 800;
  view.height_px = 600;
  return view;
}

void expectOrthonormal(const core::View& view) {
  EXPECT_NEAR(glm::length(view.forward), 1, 1e-12);
  EXPECT_NEAR(glm::length(view.up), 1, 1e-12);
  EXPECT_NEAR(glm::dot(view.forward, view.up), 0, 1e-12);
}

TEST(OrbitCamera, startsAtTheViewItWasGiven) {
  core::View view = startView();
  OrbitCamera(view, 10, kY).apply(view);
  EXPECT_NEAR(glm::distance(view.eye_model, glm::dvec3(0, 0, 10)), 0, 1e-12);
  EXPECT_NEAR(glm::distance(view.forward, glm::dvec3(0, 0, -1)), 0, 1e-12);
}

TEST(OrbitCamera, keepsItsDistanceAndItsTargetInTheMiddleWhateverIsDragged) {
  core::View view = startView();
  OrbitCamera camera(view, 10, kY);
  std::mt19937 random(2);
  for (int i = 0; i < 200; ++i) {
    camera.drag({double(random() % 400) - 200, double(random() % 400) - 200}, 600);
    camera.apply(view);
    expectOrthonormal(view);
    EXPECT_NEAR(glm::length(view.eye_model), 10, 1e-9);
    EXPECT_NEAR(glm::distance(view.eye_model + view.forward * 10.0, glm::dvec3(0)), 0, 1e-9);
    EXPECT_GT(view.up.y, 0);
  }
}

TEST(OrbitCamera, turnsTheModelTheWayItIsDragged) {
  core::View view = startView();
  OrbitCamera camera(view, 10, kY);
  const glm::dvec3 facing(0, 0, 1);
  const glm::dvec2 before = projectTo(view, facing);
  camera.drag({30, 40}, 600);
  camera.apply(view);
  const glm::dvec2 after = projectTo(view, facing);
  EXPECT_GT(after.x, before.x);
  EXPECT_GT(after.y, before.y);
}

TEST(OrbitCamera, shiftsThePointUnderThePointerWithIt) {
  core::View view = startView();
  OrbitCamera camera(view, 10, kY);
  camera.shift({37, -21}, view);
  camera.apply(view);
  const glm::dvec2 pixel = projectTo(view, {0, 0, 0});
  EXPECT_NEAR(pixel.x, 400 + 37, 1e-9);
  EXPECT_NEAR(pixel.y, 300 - 21, 1e-9);
}

TEST(OrbitCamera, comesCloserButNeverThrough) {
  core::View view = startView();
  OrbitCamera camera(view, 10, kY);
  camera.zoom(3);
  EXPECT_LT(camera.distanceModel(), 7);
  camera.zoom(1e6);
  EXPECT_GT(camera.distanceModel(), 0);
  camera.zoom(-20);
  EXPECT_TRUE(std::isfinite(camera.distanceModel()));
}

TEST(OrbitCamera, orbitsAboutAPointThatStaysInPlaceInThePicture) {
  core::View view = startView();
  OrbitCamera camera(view, 10, kY);
  const glm::dvec3 point(1, 2, 4);
  const glm::dvec2 place = projectTo(view, point);
  camera.turnAbout(point);
  camera.apply(view);
  EXPECT_NEAR(glm::distance(view.eye_model, glm::dvec3(0, 0, 10)), 0, 1e-12) << "the view stays";
  const double away = glm::distance(view.eye_model, point);
  std::mt19937 random(3);
  for (int i = 0; i < 100; ++i) {
    camera.drag({double(random() % 400) - 200, double(random() % 400) - 200}, 600);
    camera.apply(view);
    expectOrthonormal(view);
    EXPECT_NEAR(glm::distance(projectTo(view, point), place), 0, 1e-6);
    EXPECT_NEAR(glm::distance(view.eye_model, point), away, 1e-9);
  }
}

TEST(OrbitCamera, comesCloserToThePointUnderThePointer) {
  core::View view = startView();
  OrbitCamera camera(view, 10, kY);
  const glm::dvec3 point(1, 2, 4);
  const glm::dvec2 place = projectTo(view, point);
  camera.turnAbout(point);
  camera.zoom(3);
  camera.apply(view);
  EXPECT_NEAR(glm::distance(projectTo(view, point), place), 0, 1e-6);
  EXPECT_LT(camera.distanceModel(), 4);
}

TEST(OrbitCamera, fliesUntilThePointIsInTheMiddleAndNearer) {
  core::View view = startView();
  OrbitCamera camera(view, 10, kY);
  const glm::dvec3 point(1, 2, 4);
  camera.flyTo(point);
  int frames = 0;
  for (; camera.isFlying() && frames < 1000; ++frames) camera.advance(0.01);
  camera.apply(view);
  EXPECT_GT(frames, 10);
  EXPECT_LT(frames, 200);
  EXPECT_NEAR(glm::distance(projectTo(view, point), glm::dvec2(400, 300)), 0, 1e-6);
  EXPECT_LT(glm::distance(view.eye_model, point), 3);
}

TEST(OrbitCamera, endsAFlightWhenDragged) {
  const core::View view = startView();
  OrbitCamera camera(view, 10, kY);
  camera.flyTo({1, 2, 4});
  camera.advance(0.1);
  EXPECT_TRUE(camera.isFlying());
  camera.drag({1, 0}, 600);
  EXPECT_FALSE(camera.isFlying());
}

TEST(FlyCamera, movesAlongItsOwnAxes) {
  core::View view = startView();
  FlyCamera camera(view, 2, kY);
  camera.move({.right = 1, .up = -1, .forward = 1}, 0.5);
  camera.apply(view);
  EXPECT_NEAR(glm::distance(view.eye_model, glm::dvec3(1, -1, 9)), 0, 1e-12);
  camera.move({.forward = 1, .fast = true}, 0.5);
  camera.apply(view);
  EXPECT_NEAR(view.eye_model.z, 5, 1e-12);
}

TEST(FlyCamera, keepsThePointUnderThePointerWhenItLooksAround) {
  core::View view = startView();
  FlyCamera camera(view, 2, kY);
  const glm::dvec3 point(0, 0, -1000);
  camera.look({20, 12}, view);
  camera.apply(view);
  expectOrthonormal(view);
  const glm::dvec2 pixel = projectTo(view, point);
  EXPECT_NEAR(pixel.x, 400 + 20, 5);
  EXPECT_NEAR(pixel.y, 300 + 12, 5);
}

TEST(FlyCamera, neverTurnsOverAtThePoles) {
  core::View view = startView();
  FlyCamera camera(view, 2, kY);
  for (int i = 0; i < 100; ++i) camera.look({3, 200}, view);
  camera.apply(view);
  expectOrthonormal(view);
  EXPECT_GT(view.up.y, 0);
  EXPECT_GT(view.forward.y, 0.99);
}

TEST(FlyCamera, keepsItsSpeedWithinBounds) {
  core::View view = startView();
  FlyCamera camera(view, 2, kY);
  camera.changeSpeed(1e5);
  EXPECT_DOUBLE_EQ(camera.speedModel(), 2e4);
  camera.changeSpeed(-1e5);
  EXPECT_DOUBLE_EQ(camera.speedModel(), 2e-4);
}

TEST(Heading, acceptsADirectionAlongItsAxis) {
  core::View view = startView();
  view.forward = {0, -1, 0};
  view.up = {0, 0, -1};
  FlyCamera(view, 1, kY).apply(view);
  expectOrthonormal(view);
  EXPECT_LT(view.forward.y, -0.99);
}

TEST(Heading, worksAboutAnyAxis) {
  core::View view = startView();
  view.forward = glm::normalize(glm::dvec3(1, 0.5, 0.25));
  const Heading heading(view, {0, 0, 3});
  EXPECT_NEAR(glm::distance(heading.forward(), view.forward), 0, 1e-12);
  EXPECT_NEAR(glm::dot(heading.right(), glm::dvec3(0, 0, 1)), 0, 1e-12);
  EXPECT_GT(heading.up().z, 0);
}

}  // namespace
}  // namespace lode::app
