#include "server/ingest/measure/lod_surface.h"

#include <random>

#include <gtest/gtest.h>

#include "tests/support/node_meshes.h"

namespace lode::ingest {
namespace {

glm::vec3 pointNear(std::mt19937& random) { return glm::vec3(random() % 64, random() % 64, random() % 64); }

TEST(LodSurface, findsTheNearestTriangleForFewAndManyPoints) {
  const NodeMesh mesh = test::makeTangle(200, 300, 8);
  const TriangleTree tree(mesh);
  const LodSurface surface(mesh);
  std::mt19937 random(5);
  for (int i = 0; i < 200; ++i) {  // the first points by exhaustive search, the others by the tree
    const glm::vec3 point = pointNear(random);
    EXPECT_FLOAT_EQ(surface.nearest(point).distance, tree.distance(point)) << i;
  }
}

TEST(LodSurface, measuresExactlyBeyondTheTolerance) {
  const NodeMesh mesh = test::makeTangle(200, 300, 8);
  const TriangleTree tree(mesh);
  const LodSurface surface(mesh);
  std::mt19937 random(6);
  for (int i = 0; i < 200; ++i) {
    const glm::vec3 point = pointNear(random);
    const float tolerance = static_cast<float>(i % 8), expected = tree.distance(point);
    const float measured = surface.measure(point, static_cast<uint32_t>(i), tolerance).distance;
    if (expected > tolerance)
      EXPECT_FLOAT_EQ(measured, expected) << i;
    else
      EXPECT_LE(measured, tolerance) << i;
  }
}

TEST(LodSurface, neverUnderstatesTheDistanceOnAWalk) {
  const NodeMesh mesh = test::makeTangle(200, 300, 8);
  const TriangleTree tree(mesh);
  const LodSurface surface(mesh);
  std::mt19937 random(7);
  for (uint32_t i = 0; i < 200; ++i) {
    const glm::vec3 point = pointNear(random);
    EXPECT_GE(surface.walkFrom(point, i, 0).distance * 1.0001f + 1e-4f, tree.distance(point)) << i;
  }
}

}  // namespace
}  // namespace lode::ingest
