#include "client/core/lod/part_error.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>

#include <gtest/gtest.h>

#include "client/core/lod/triangle_clusters.h"
#include "tests/support/seeds.h"
#include "tests/unit/core/scripted_client.h"

namespace lode::core {
namespace {

using fixture::lookingAt;

constexpr double kStep = 1.0 / 1024;

/// A part with a mesh, in the box of its vertices with `error_model` around it.
CutPart partOf(Mesh mesh, float error_model) {
  clusterTriangles(mesh);
  LatticeBox box;
  for (const PositionCode position : mesh.positions) box.add(unpackPosition(position));
  CutPart part;
  part.error_model = part.off_model = error_model;
  part.box = toModelBox(box, kStep);
  part.box.min -= static_cast<double>(error_model);
  part.box.max += static_cast<double>(error_model);
  part.mesh = std::make_shared<const Mesh>(std::move(mesh));
  return part;
}

/// The six sides of a box as twelve triangles.
Mesh room(glm::uvec3 size) {
  constexpr uint32_t kSides[12][3] = {{0, 1, 3}, {0, 3, 2}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                                      {2, 3, 7}, {2, 7, 6}, {0, 2, 6}, {0, 6, 4}, {1, 3, 7}, {1, 7, 5}};
  Mesh mesh;
  for (uint32_t corner = 0; corner < 8; ++corner)
    mesh.positions.push_back(packPosition(size * glm::uvec3(corner & 1, corner >> 1 & 1, corner >> 2)));
  for (const auto& side : kSides) mesh.triangles.emplace_back(side[0], side[1], side[2]);
  return mesh;
}

/// Triangles of all sizes anywhere in a box.
Mesh randomSurface(std::mt19937& random) {
  std::uniform_int_distribution<uint32_t> anywhere(0, 1u << 16), size(1, 1u << 12);
  Mesh mesh;
  const uint32_t count = std::uniform_int_distribution<uint32_t>(20, 820)(random);
  for (uint32_t i = 0; i < count; ++i) {
    const glm::uvec3 at(anywhere(random), anywhere(random), anywhere(random));
    for (int corner = 0; corner < 3; ++corner)
      mesh.positions.push_back(packPosition(at + glm::uvec3(size(random), size(random), size(random))));
    mesh.triangles.emplace_back(3 * i, 3 * i + 1, 3 * i + 2);
  }
  return mesh;
}

class PartError : public testing::TestWithParam<uint32_t> {
 protected:
  double roll() { return std::uniform_real_distribution<double>()(random_); }
  glm::dvec3 direction() {
    glm::dvec3 v;
    do v = 2.0 * glm::dvec3(roll(), roll(), roll()) - 1.0;
    while (glm::length(v) > 1 || glm::length(v) < 1e-3);
    return glm::normalize(v);
  }
  glm::dvec3 pointOn(const Mesh& mesh) {
    const glm::u32vec3 t = mesh.triangles[random_() % mesh.triangles.size()];
    double u = roll(), v = roll();
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const auto corner = [&](uint32_t i) { return glm::dvec3(unpackPosition(mesh.positions[i])) * kStep; };
    return corner(t.x) + u * (corner(t.y) - corner(t.x)) + v * (corner(t.z) - corner(t.x));
  }
  static bool isInPicture(glm::dvec3 point, const View& view) {
    const glm::dvec3 away = point - view.eye_model, right = glm::cross(view.forward, view.up);
    const double depth = glm::dot(away, view.forward), tan_y = std::tan(view.fov_y_rad / 2);
    return depth > 0 && std::abs(glm::dot(away, view.up)) <= depth * tan_y &&
           std::abs(glm::dot(away, right)) <= depth * tan_y * view.width_px / view.height_px;
  }

  std::mt19937 random_{GetParam()};
};

INSTANTIATE_TEST_SUITE_P(Seeds, PartError, testing::Range(1u, 1 + lode::test::kSeeds));

TEST_P(PartError, boundsTheDeviationOfEveryOriginalPointInThePicture) {
  for (int scene = 0; scene < 4; ++scene) {
    const auto error_model = static_cast<float>(4 * std::pow(10, -3 * roll()));
    const CutPart part = partOf(randomSurface(random_), error_model);
    for (int camera = 0; camera < 8; ++camera) {
      const glm::dvec3 eye = 70.0 * glm::dvec3(roll(), roll(), roll());
      const View view = lookingAt(eye, eye + direction());
      const double told_px = partErrorPx(part, kStep, ViewFrustum(view, 1));
      for (int i = 0; i < 200; ++i) {
        const glm::dvec3 drawn = pointOn(*part.mesh);
        const glm::dvec3 original = drawn + roll() * static_cast<double>(error_model) * direction();
        if (!isInPicture(drawn, view) && !isInPicture(original, view)) continue;
        const double off_px =
            focalPx(view) * glm::distance(glm::normalize(drawn - eye), glm::normalize(original - eye));
        ASSERT_GE(told_px * (1 + 1e-5), off_px);
      }
    }
  }
}

TEST_P(PartError, isNeverMoreThanTheErrorOfTheBox) {
  const CutPart part = partOf(randomSurface(random_), 0.1f);
  for (int camera = 0; camera < 20; ++camera) {
    const glm::dvec3 eye = 200.0 * glm::dvec3(roll(), roll(), roll()) - 70.0;
    const ViewFrustum frustum(lookingAt(eye, eye + direction()), 1);
    EXPECT_LE(partErrorPx(part, kStep, frustum), partErrorPx(part, 0, frustum));
  }
}

TEST_P(PartError, isMeasuredAtTheWallsInTheMiddleOfARoom) {
  const double step = 0.001;
  const CutPart part = [&] {
    CutPart made = partOf(room({22'000, 20'000, 3'000}), 0.0005f);
    made.box = {{0, 0, 0}, {22, 20, 3}};
    return made;
  }();
  const glm::dvec3 eye = glm::dvec3(1.5) + glm::dvec3(19 * roll(), 17 * roll(), 0);
  const View view = lookingAt(eye, eye + direction());
  EXPECT_GT(partErrorPx(part, 0, ViewFrustum(view, 1)), 1000) << "the box holds the eye";
  EXPECT_LE(partErrorPx(part, step, ViewFrustum(view, 1)), screenErrorPx(0.0005f, 1.499, view));
}

TEST(PartErrorOfAWall, isMeasuredAtTheVisibleWall) {
  const double step = 0.001;
  Mesh walls = room({22'000, 20'000, 3'000});
  std::erase_if(walls.triangles, [&](glm::u32vec3 t) {  // leaves the walls at both ends of y
    const auto y = [&](uint32_t i) { return unpackPosition(walls.positions[i]).y; };
    return y(t.x) != y(t.y) || y(t.x) != y(t.z);
  });
  CutPart part = partOf(walls, 0.0005f);
  part.box = {{0, 0, 0}, {22, 20, 3}};
  const View view = lookingAt({11, 2, 1.5}, {11, 20, 1.5});
  EXPECT_NEAR(partErrorPx(part, step, ViewFrustum(view, 1)), screenErrorPx(0.0005f, 18, view), 1e-4);
}

TEST(PartErrorOfAWall, isMeasuredAtTheVisiblePartOfTheFloor) {
  CutPart part = partOf(room({22'000, 20'000, 3'000}), 0.0005f);
  part.box = {{0, 0, 0}, {22, 20, 3}};
  View view = lookingAt({11, 12, 1.5}, {11, 20, 1.5});
  view.up = {0, 0, 1};
  const double nearest = 1.5 / std::sin(view.fov_y_rad / 2);
  EXPECT_NEAR(partErrorPx(part, 0.001, ViewFrustum(view, 1)), screenErrorPx(0.0005f, nearest, view), 1e-3);
}

TEST(PartErrorOfAWall, isZeroIfOnlyTheBoxIsInThePicture) {
  CutPart part = partOf(room({1000, 1000, 1}), 0.0005f);
  part.box = {{0, 0, 0}, {1, 1, 1}};
  EXPECT_EQ(partErrorPx(part, 0.001, ViewFrustum(lookingAt({0.5, 0.5, 0.5}, {0.5, 0.5, 1}), 1)), 0);
}

}  // namespace
}  // namespace lode::core
