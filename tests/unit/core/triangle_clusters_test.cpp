#include "client/core/lod/triangle_clusters.h"

#include <algorithm>
#include <random>
#include <tuple>

#include <gtest/gtest.h>

#include "tests/support/test_meshes.h"

namespace lode::core {
namespace {

/// A bumpy sphere with triangles in random order.
Mesh shuffledSphere(uint32_t seed) {
  Mesh mesh = test::makeSphere(80, 40, {.attributes = {}, .seed = seed, .bump = 0.1});
  std::ranges::shuffle(mesh.triangles, std::mt19937(seed));
  return mesh;
}

std::vector<glm::u32vec3> sorted(std::vector<glm::u32vec3> triangles) {
  std::ranges::sort(triangles, {}, [](const glm::u32vec3& t) { return std::tuple(t.x, t.y, t.z); });
  return triangles;
}

double diagonalOf(const LatticeBox& box) { return glm::length(glm::dvec3(box.max) - glm::dvec3(box.min)); }

TEST(TriangleClusters, keepEachTriangleAndItsWinding) {
  const Mesh before = shuffledSphere(1);
  Mesh mesh = before;
  clusterTriangles(mesh);
  EXPECT_EQ(mesh.positions, before.positions);
  EXPECT_EQ(sorted(mesh.triangles), sorted(before.triangles));
}

TEST(TriangleClusters, haveTheirBoundingBoxes) {
  Mesh mesh = shuffledSphere(2);
  clusterTriangles(mesh);
  ASSERT_EQ(mesh.cluster_boxes.size(), clusterCount(mesh.triangles.size()));
  std::vector<LatticeBox> boxes(mesh.cluster_boxes.size());
  for (size_t i = 0; i < mesh.triangles.size(); ++i)
    for (int corner = 0; corner < 3; ++corner)
      boxes[i / kClusterTriangles].add(unpackPosition(mesh.positions[mesh.triangles[i][corner]]));
  EXPECT_EQ(mesh.cluster_boxes, boxes);
}

TEST(TriangleClusters, areSmall) {
  Mesh mesh = shuffledSphere(3);
  clusterTriangles(mesh);
  LatticeBox whole;
  double mean = 0;
  for (const LatticeBox& box : mesh.cluster_boxes) {
    whole.add(box);
    mean += diagonalOf(box) / static_cast<double>(mesh.cluster_boxes.size());
  }
  // 50 squares would cover 0.2 of it; in the original order each cluster covers nearly all of it.
  EXPECT_LT(mean, 0.4 * diagonalOf(whole));
}

TEST(TriangleClusters, areOneWhereTrianglesAreFew) {
  Mesh few = test::makeSphere(10, 6, {.attributes = {}});
  const std::vector<glm::u32vec3> before = few.triangles;
  clusterTriangles(few);
  EXPECT_EQ(few.triangles, before);
  EXPECT_EQ(few.cluster_boxes.size(), 1u);
  Mesh none;
  clusterTriangles(none);
  EXPECT_TRUE(none.cluster_boxes.empty());
}

TEST(TriangleClusters, areFullExceptTheLastIfAllTrianglesCoincide) {
  Mesh mesh;
  for (uint32_t i = 0; i < 3; ++i) mesh.positions.push_back(packPosition({i, i * i, 0}));
  mesh.triangles.assign(1000, {0, 1, 2});
  clusterTriangles(mesh);
  EXPECT_EQ(mesh.triangles.size(), 1000u);
  EXPECT_EQ(mesh.cluster_boxes.size(), clusterCount(1000));
}

}  // namespace
}  // namespace lode::core
