#include "server/ingest/inspect/lod_check.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "server/ingest/measure/triangle_tree.h"
#include "server/ingest/mesh/mesh_welder.h"
#include "server/ingest/simplify/collapse.h"
#include "tests/support/node_meshes.h"
#include "tests/support/test_meshes.h"

namespace lode::ingest {
namespace {

LatticeBox boxOf(const Mesh& mesh) {
  LatticeBox box;
  for (const PositionCode position : mesh.positions) box.add(unpackPosition(position));
  return box;
}

float found(const Mesh& lod, const Mesh& leaf, float stored_steps, uint64_t seed = 1) {
  LatticeBox box = boxOf(leaf);
  for (const PositionCode position : lod.positions) box.add(unpackPosition(position));
  LodCheck check(lod, box, stored_steps, leaf.triangles.size(), seed);
  check.add(LeafSurface(leaf));
  return static_cast<float>(check.found());
}

Mesh flatGrid() {
  test::MeshOptions options;
  options.extent = 6000;
  return test::makeGrid(60, 60, options);
}

void addTriangle(Mesh& mesh, glm::uvec3 at, uint32_t size) {
  const auto first = static_cast<uint32_t>(mesh.positions.size());
  for (const glm::uvec3 corner : {at, at + glm::uvec3(size, 0, 0), at + glm::uvec3(0, size, 0)})
    mesh.positions.push_back(packPosition(corner));
  mesh.triangles.emplace_back(first, first + 1, first + 2);
}

TEST(LodCheck, agreesWithDensePointsInBothDirections) {
  const Mesh leaf = test::makeSphere(60, 40);
  const NodeMesh input = test::nodeOf(leaf);
  collapse(input, std::array<size_t, 2>{1200, 100}, {}, [&](size_t, SimplifiedMesh&& lod) {
    const TriangleTree to_lod(lod.mesh), to_input(input);
    double dense = 0;
    for (const glm::dvec3 point : test::pointsOver(input, 16))
      dense = std::max<double>(dense, to_lod.distance(glm::vec3(point)));
    for (const glm::dvec3 point : test::pointsOver(lod.mesh, 16))
      dense = std::max<double>(dense, to_input.distance(glm::vec3(point)));
    const float of_lod = found(toMesh(lod.mesh), leaf, static_cast<float>(dense));
    EXPECT_GE(of_lod, 0.95 * dense);
    EXPECT_LE(of_lod, 1.05 * dense);
  });
}

TEST(LodCheck, findsOneTinyMissingTriangleForEverySeed) {
  const Mesh lod = flatGrid();
  Mesh leaf = lod;
  addTriangle(leaf, {3000, 3000, 5000}, 2);
  const float height = TriangleTree(test::nodeOf(lod)).distance(glm::vec3(3001, 3001, 5000));
  for (uint64_t seed = 1; seed <= 5; ++seed) EXPECT_GE(found(lod, leaf, height / 3, seed), 0.98f * height);
}

TEST(LodCheck, findsALodVertexFarFromAllLeavesForEverySeed) {
  const Mesh leaf = flatGrid();
  Mesh lod = leaf;
  addTriangle(lod, {3000, 3000, 5000}, 2);
  for (uint64_t seed = 1; seed <= 5; ++seed) EXPECT_GT(found(lod, leaf, 400, seed), 1.25f * 400);
}

TEST(LodCheck, measuresNothingBelowThreeQuartersOfTheStoredError) {
  const Mesh mesh = test::makeGrid(10, 10);
  EXPECT_EQ(found(mesh, mesh, 40), 30);
}

}  // namespace
}  // namespace lode::ingest
