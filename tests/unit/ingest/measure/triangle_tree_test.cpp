#include "server/ingest/measure/triangle_tree.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "server/ingest/mesh/mesh_welder.h"
#include "tests/support/node_meshes.h"

namespace lode::ingest {
namespace {

NodeMesh randomTriangles(size_t count, uint32_t extent, uint32_t size) {
  std::mt19937 random(5);
  MeshWelder welder;
  welder.begin({}, 3 * count, count);
  for (size_t t = 0; t < count; ++t) {
    const glm::uvec3 base(random() % extent, random() % extent, random() % extent);
    glm::u32vec3 corners;
    for (int k = 0; k < 3; ++k) {
      const glm::uvec3 at = base + glm::uvec3(random() % size, random() % size, random() % size);
      corners[k] = welder.addCorner(packPosition(at), kNeverLocked, {});
    }
    welder.addTriangle(corners);
  }
  return welder.finish();
}

/// Smallest distance to a fine grid on every triangle; an upper bound of the true distance.
double bruteDistance(const NodeMesh& mesh, glm::dvec3 point) {
  double best = 1e30;
  for (const glm::dvec3 on : test::pointsOver(mesh, 24)) best = std::min(best, glm::distance(on, point));
  return best;
}

TEST(TriangleTree, agreesWithBruteForce) {
  std::mt19937 random(9);
  for (const uint32_t size : {20u, 400u}) {
    const NodeMesh mesh = randomTriangles(200, 1000, size);
    const TriangleTree tree(mesh);
    for (int i = 0; i < 100; ++i) {
      const glm::uvec3 point(random() % 1400, random() % 1400, random() % 1400);
      const double expected = bruteDistance(mesh, glm::dvec3(point));
      const double found = tree.distance(glm::vec3(point));
      EXPECT_LE(found, expected + 1e-2);
      EXPECT_GE(found, expected - size / 12.0);  // error of the barycentric grid
    }
  }
}

float nearestOfAll(const TriangleTree& tree, const NodeMesh& mesh, glm::vec3 point) {
  float squared = TriangleTree::kInfinity;
  for (uint32_t t = 0; t < mesh.triangles.size(); ++t)
    squared = std::min(squared, tree.squaredDistance(point, t));
  return std::sqrt(squared);
}

/// Triangles of all sizes around one centroid, which boxes cannot separate.
NodeMesh trianglesAroundOneMiddle(size_t count) {
  std::mt19937 random(6);
  MeshWelder welder;
  welder.begin({}, 3 * count, count);
  for (size_t t = 0; t < count; ++t) {
    const auto reach = static_cast<int>(2u << random() % 14);
    const auto step = [&] { return static_cast<int>(random() % (2 * static_cast<unsigned>(reach))) - reach; };
    const glm::ivec3 a(step(), step(), step()), b(step(), step(), step()), middle(1 << 16);
    glm::u32vec3 corners;
    int k = 0;
    for (const glm::ivec3 away : {a, b, -a - b})
      corners[k++] = welder.addCorner(packPosition(glm::uvec3(middle + away)), kNeverLocked, {});
    welder.addTriangle(corners);
  }
  return welder.finish();
}

TEST(TriangleTree, findsTheNearestOfLongAndOfConcentricTriangles) {
  std::mt19937 random(7);
  for (const NodeMesh& mesh : {randomTriangles(2000, 1, 100000), trianglesAroundOneMiddle(2000)}) {
    const TriangleTree tree(mesh);
    for (int i = 0; i < 100; ++i) {
      const glm::vec3 point(random() % (1 << 17), random() % (1 << 17), random() % (1 << 17));
      const TriangleTree::Nearest found = tree.nearest(point);
      EXPECT_EQ(found.distance, nearestOfAll(tree, mesh, point));
      EXPECT_EQ(found.squared, tree.squaredDistance(point, found.triangle));
    }
  }
}

TEST(TriangleTree, stopsAtTheKnownDistanceAndAtTheTolerance) {
  const NodeMesh mesh = randomTriangles(200, 1000, 50);
  const TriangleTree tree(mesh);
  const glm::vec3 point(500, 500, 3000);
  const float nearest = tree.distance(point);
  const float nearer = nearest / 2, farther = nearest * 2;
  EXPECT_EQ(tree.nearest(point, 0, {nearer * nearer, nearer, 7}).triangle, 7u);
  EXPECT_EQ(tree.nearest(point, 0, {farther * farther, farther, 7}).distance, nearest);
  EXPECT_GE(tree.nearest(point, farther).distance, nearest);
  EXPECT_LE(tree.nearest(point, farther).distance, farther);
}

TEST(TriangleTree, isInfinitelyFarFromAnEmptyMesh) {
  EXPECT_TRUE(std::isinf(TriangleTree(NodeMesh{}).distance({1, 2, 3})));
}

}  // namespace
}  // namespace lode::ingest
