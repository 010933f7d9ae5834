#include "client/core/view/framing.h"

#include <algorithm>
#include <array>

#include <gtest/gtest.h>

#include "tests/support/test_meshes.h"

namespace lode::core {
namespace {

ModelSummary modelOf(const LatticeBox& box) {
  ModelSummary model;
  model.lattice = {{1e6, -2e6, 30}, 1.0 / 1024};
  model.box = box;
  return model;
}

std::vector<glm::uvec3> cornersOf(const LatticeBox& box) {
  std::vector<glm::uvec3> corners;
  for (int i = 0; i < 8; ++i)
    corners.emplace_back(i & 1 ? box.max.x : box.min.x, i & 2 ? box.max.y : box.min.y,
                         i & 4 ? box.max.z : box.min.z);
  return corners;
}

/// Extent of points in the picture: 1 is its edge.
struct Filled {
  glm::dvec2 low{1e9}, high{-1e9};
  bool all_in_front = true;
};

Filled fill(const CameraPath& path, const ModelSummary& model, const std::vector<glm::uvec3>& points,
            uint32_t width_px, uint32_t height_px) {
  const View view = toView(path.keys[0], path.fov_y_deg, width_px, height_px, model);
  const double slope = std::tan(view.fov_y_rad / 2), aspect = double(width_px) / height_px;
  Filled filled;
  for (const glm::uvec3& point : points) {
    const glm::dvec3 at = glm::dvec3(model.lattice.toModel(point)) - view.eye_model;
    const double out = glm::dot(at, view.forward);
    filled.all_in_front &= out > 0;
    const glm::dvec2 seen(glm::dot(at, glm::cross(view.forward, view.up)) / aspect, glm::dot(at, view.up));
    filled.low = glm::min(filled.low, seen / (out * slope));
    filled.high = glm::max(filled.high, seen / (out * slope));
  }
  return filled;
}

void expectFull(const Filled& filled) {
  EXPECT_TRUE(filled.all_in_front);
  for (int axis = 0; axis < 2; ++axis) {
    EXPECT_LT(filled.high[axis], 1);
    EXPECT_NEAR(filled.low[axis], -filled.high[axis], 0.01) << "the middle of the picture";
  }
  EXPECT_GT(std::max(filled.high.x - filled.low.x, filled.high.y - filled.low.y), 1.8);
}

TEST(Framing, fillsPicturesOfEveryShapeWithBoxesOfEveryShape) {
  for (const glm::uvec3 size : {glm::uvec3(800), {2000, 100, 100}, {100, 2000, 100}, {90, 1000, 3000}}) {
    const LatticeBox box{glm::uvec3(500), glm::uvec3(500) + size};
    for (const glm::uvec2 picture : {glm::uvec2(1280, 720), {100, 100}, {300, 900}}) {
      const Framing framing{.aspect = double(picture.x) / picture.y};
      const ModelSummary model = modelOf(box);
      expectFull(fill(framingCamera(model, framing), model, cornersOf(box), picture.x, picture.y));
    }
  }
}

TEST(Framing, fillsTheUncoveredPartOfThePicture) {
  constexpr double kCovered = 0.3;
  for (const glm::uvec3 size : {glm::uvec3(800), {2000, 100, 100}, {100, 2000, 100}}) {
    const LatticeBox box{glm::uvec3(500), glm::uvec3(500) + size};
    const ModelSummary model = modelOf(box);
    const Framing framing{.aspect = 16.0 / 9, .covered = kCovered};
    Filled filled = fill(framingCamera(model, framing), model, cornersOf(box), 1280, 720);
    filled.low.x = (filled.low.x - kCovered) / (1 - kCovered);
    filled.high.x = (filled.high.x - kCovered) / (1 - kCovered);
    expectFull(filled);
  }
}

TEST(Framing, looksSquarelyAtEachSideWithAnyFieldOfView) {
  const LatticeBox box{{500, 500, 500}, {1300, 900, 700}};
  const ModelSummary model = modelOf(box);
  const std::array<glm::dvec3, 6> forward{
      {{0, 1, 0}, {0, -1, 0}, {1, 0, 0}, {-1, 0, 0}, {0, 0, -1}, {0, 0, 1}}};  // z is up
  for (const double fov_y_deg : {45.0, 0.1}) {
    for (size_t side = 0; side < forward.size(); ++side) {
      const Framing framing{
          .up = glm::dvec3(0, 0, 1), .aspect = 1.5, .side = static_cast<Side>(side), .fov_y_deg = fov_y_deg};
      const CameraPath path = framingCamera(model, framing);
      EXPECT_EQ(path.fov_y_deg, fov_y_deg);
      expectFull(fill(path, model, cornersOf(box), 900, 600));
      const View view = toView(path.keys[0], path.fov_y_deg, 900, 600, model);
      EXPECT_LT(glm::distance(view.forward, forward[side]), 1e-9) << kSideNames[side];
      const double rightwards = glm::cross(view.forward, view.up).x;
      EXPECT_TRUE(side < 4 || rightwards > 0.999) << "from above and below, x points to the right";
    }
  }
}

TEST(Framing, fillsThePictureWithAMeshSmallerThanItsBox) {
  const auto mesh = std::make_shared<Mesh>(test::makeSphere(24, 12));
  const ModelSummary model = modelOf(test::boxOf(*mesh));
  std::vector<glm::uvec3> points;
  for (const PositionCode code : mesh->positions) points.push_back(unpackPosition(code));
  expectFull(fill(framingCamera(model, {.coarse = mesh}), model, points, 640, 640));
}

TEST(Framing, leavesRoomForTheErrorOfACoarseMesh) {
  const auto mesh =
      std::make_shared<Mesh>(test::makeSphere(24, 12, {.attributes = {}, .origin = glm::uvec3(2000)}));
  LatticeBox box = test::boxOf(*mesh);
  box.add(glm::uvec3(0));
  box.add(box.max + 2000u);
  ModelSummary model = modelOf(box);
  const CameraKey exact = framingCamera(model, {.coarse = mesh}).keys[0];
  model.max_error_model = 0.5;
  const CameraKey lossy = framingCamera(model, {.coarse = mesh}).keys[0];
  const double half_angle = glm::radians(45.0 / 2);
  EXPECT_GE(glm::distance(lossy.eye, exact.eye), 0.5 / std::sin(half_angle) * 0.999);
}

TEST(Framing, leavesRoomForNothingOutsideTheBox) {
  const auto mesh = std::make_shared<Mesh>(test::makeSphere(24, 12));
  ModelSummary model = modelOf(test::boxOf(*mesh));
  const CameraKey of_box = framingCamera(model).keys[0];
  model.max_error_model = 1e6;
  const CameraKey lossy = framingCamera(model, {.coarse = mesh}).keys[0];
  EXPECT_LE(glm::distance(lossy.eye, lossy.target), 1.001 * glm::distance(of_box.eye, of_box.target));
}

TEST(Framing, looksFromThreeQuartersAboveForAnyUpAxis) {
  const ModelSummary model = modelOf({glm::uvec3(0), glm::uvec3(1000)});
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {1.0, -1.0}) {
      glm::dvec3 up(0);
      up[axis] = sign;
      const CameraKey key = framingCamera(model, {.up = up}).keys[0];
      const glm::dvec3 to_eye = glm::normalize(key.eye - key.target);
      EXPECT_EQ(key.up, up);
      EXPECT_GT(glm::dot(to_eye, up), 0.25);
      EXPECT_GT(std::min({std::abs(to_eye.x), std::abs(to_eye.y), std::abs(to_eye.z)}), 0.25);
    }
  }
}

TEST(Framing, looksFromTheFrontThatBelongsToTheUpAxis) {
  const ModelSummary model = modelOf({glm::uvec3(0), glm::uvec3(1000)});
  const CameraKey y_up = framingCamera(model, {.up = glm::dvec3(0, 1, 0)}).keys[0];
  const CameraKey z_up = framingCamera(model, {.up = glm::dvec3(0, 0, 1)}).keys[0];
  EXPECT_GT(y_up.eye.z - y_up.target.z, y_up.eye.x - y_up.target.x);
  EXPECT_GT(z_up.target.y - z_up.eye.y, z_up.eye.x - z_up.target.x);
}

TEST(Framing, looksAtTheBroaderSide) {
  const ModelSummary model = modelOf({glm::uvec3(0), glm::uvec3(100, 500, 900)});
  const CameraKey key = framingCamera(model).keys[0];
  EXPECT_GT(key.eye.x - key.target.x, key.eye.z - key.target.z);
}

TEST(Framing, looksDownMoreSteeplyOnAFlatModel) {
  const auto tilt = [](glm::uvec3 size) {
    const CameraKey key = framingCamera(modelOf({glm::uvec3(0), size})).keys[0];
    return glm::normalize(key.eye - key.target).y;
  };
  EXPECT_GT(tilt({1000, 50, 1000}), tilt({1000, 1000, 1000}) + 0.15);
}

TEST(Framing, hasACameraForAModelThatIsOnePoint) {
  const CameraKey key = framingCamera(modelOf({glm::uvec3(7), glm::uvec3(7)})).keys[0];
  EXPECT_GT(glm::distance(key.eye, key.target), 0);
}

}  // namespace
}  // namespace lode::core
