#include "server/ingest/mesh/mesh_edges.h"

#include <array>

#include <gtest/gtest.h>

#include "tests/support/node_meshes.h"

namespace lode::ingest {
namespace {

/// A square of four triangles about its centre, position 4.
NodeMesh makeSquare() {
  NodeMesh mesh;
  for (const glm::uvec3 place : {glm::uvec3(0, 0, 0), {8, 0, 0}, {8, 8, 0}, {0, 8, 0}, {4, 4, 0}})
    mesh.positions.push_back(packPosition(place));
  mesh.wedge_position = {0, 1, 2, 3, 4};
  mesh.lca_depth.assign(5, kNeverLocked);
  mesh.triangles = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  return mesh;
}

TEST(MeshEdges, areListedOnceWithTheirTriangles) {
  std::array<std::array<uint32_t, 5>, 5> uses{};
  forEachEdge(makeSquare(), [&](uint32_t lower, uint32_t upper, uint32_t count) {
    EXPECT_LT(lower, upper);
    EXPECT_EQ(std::exchange(uses[lower][upper], count), 0u);
  });
  for (uint32_t corner = 0; corner < 4; ++corner) {
    EXPECT_EQ(uses[corner][4], 2u);
    EXPECT_EQ(uses[std::min(corner, (corner + 1) % 4)][std::max(corner, (corner + 1) % 4)], 1u);
  }
}

TEST(OpenEdges, areTheEdgesOfAnOddNumberOfTriangles) {
  const std::vector<glm::u32vec2> expected{{0, 1}, {0, 3}, {1, 2}, {2, 3}};
  EXPECT_EQ(openEdges(makeSquare()), expected);
  EXPECT_TRUE(openEdges(test::nodeOf(test::makeSphere(12, 8))).empty());
}

TEST(Border, hasTheVerticesOfEdgesNotUsedTwice) {
  EXPECT_EQ(findBorder(makeSquare()), (std::vector<uint32_t>{0, 1, 2, 3})) << "the centre alone is inside";
}

TEST(Border, hasTheVerticesOfEdgesThatMoreThanTwoTrianglesUse) {
  // A closed surface with a fin on one of its edges.
  NodeMesh mesh = test::nodeOf(test::makeSphere(12, 8));
  ASSERT_TRUE(findBorder(mesh).empty());
  const glm::u32vec3 t = mesh.triangles[0];
  mesh.wedge_position.push_back(static_cast<uint32_t>(mesh.positions.size()));
  mesh.positions.push_back(packPosition({1, 2, 3}));
  const auto tip = static_cast<uint32_t>(mesh.wedge_position.size() - 1);
  mesh.triangles.emplace_back(t.x, t.y, tip);
  EXPECT_EQ(findBorder(mesh).size(), 3u);
  mesh.triangles.emplace_back(t.y, t.x, tip);
  EXPECT_EQ(findBorder(mesh).size(), 2u)
      << "the fin's other side: its boundaries are used twice, its foot 4 times";
}

}  // namespace
}  // namespace lode::ingest
