#include "server/ingest/surface_walk.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "server/ingest/triangle_grid.h"
#include "tests/support/node_meshes.h"

namespace lode::ingest {
namespace {

TEST(SurfaceWalk, isAsFarAsTheGridSaysFromASmoothSurface) {
  const NodeMesh mesh = test::nodeOf(test::makeSphere(60, 40));
  const TriangleGrid grid(mesh);
  const SurfaceWalk walk(mesh);
  std::mt19937 random(3);
  for (uint32_t i = 0; i < mesh.positions.size(); ++i) {
    const glm::uvec3 point =
        unpackPosition(mesh.positions[i]) + glm::uvec3(random() % 9, random() % 9, random() % 9);
    EXPECT_FLOAT_EQ(walk.distance(glm::vec3(point), i, 0), grid.distance(packPosition(point)));
  }
}

TEST(SurfaceWalk, isNeverNearerThanTheTruthWhereverItStarts) {
  const NodeMesh mesh = test::makeTangle(200, 300, 7);
  const TriangleGrid grid(mesh);
  const SurfaceWalk walk(mesh);
  std::mt19937 random(4);
  for (int i = 0; i < 500; ++i) {
    const glm::uvec3 point(random() % 64, random() % 64, random() % 64);
    const float distance =
        walk.distance(glm::vec3(point), mesh.wedge_position[mesh.triangles[random() % 300].x], 0);
    EXPECT_GE(distance * 1.0001f + 1e-4f, grid.distance(packPosition(point)));
  }
}

TEST(SurfaceWalk, looksAtEveryTriangleForTheExactDistance) {
  const NodeMesh mesh = test::makeTangle(200, 300, 8);
  const TriangleGrid grid(mesh);
  const SurfaceWalk walk(mesh);
  std::mt19937 random(5);
  for (int i = 0; i < 500; ++i) {
    const glm::uvec3 point(random() % 64, random() % 64, random() % 64);
    EXPECT_NEAR(walk.exactDistance(glm::vec3(point), 1e3f), grid.distance(packPosition(point)), 1e-3);
  }
}

TEST(SurfaceWalk, isInfinitelyFarWhereItStartsAtNoTriangle) {
  NodeMesh mesh = test::nodeOf(test::makeGrid(4, 4));
  mesh.triangles.clear();
  EXPECT_TRUE(std::isinf(SurfaceWalk(mesh).distance({1, 2, 3}, 0, 0)));
}

}  // namespace
}  // namespace lode::ingest
