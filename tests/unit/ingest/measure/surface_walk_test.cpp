#include "server/ingest/measure/surface_walk.h"

#include <array>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "server/ingest/measure/triangle_tree.h"
#include "tests/support/node_meshes.h"

namespace lode::ingest {
namespace {

TEST(SurfaceWalk, agreesWithTheTreeOnASmoothSurface) {
  const NodeMesh mesh = test::nodeOf(test::makeSphere(60, 40));
  const TriangleTree tree(mesh);
  const SurfaceWalk walk(mesh);
  std::mt19937 random(3);
  for (uint32_t i = 0; i < mesh.positions.size(); ++i) {
    const glm::uvec3 point =
        unpackPosition(mesh.positions[i]) + glm::uvec3(random() % 9, random() % 9, random() % 9);
    EXPECT_FLOAT_EQ(walk.distance(glm::vec3(point), i, 0), tree.distance(glm::vec3(point)));
  }
}

TEST(SurfaceWalk, neverUnderstatesTheDistance) {
  const NodeMesh mesh = test::makeTangle(200, 300, 7);
  const TriangleTree tree(mesh);
  const SurfaceWalk walk(mesh);
  std::mt19937 random(4);
  for (int i = 0; i < 500; ++i) {
    const glm::uvec3 point(random() % 64, random() % 64, random() % 64);
    const float distance =
        walk.distance(glm::vec3(point), mesh.wedge_position[mesh.triangles[random() % 300].x], 0);
    EXPECT_GE(distance * 1.0001f + 1e-4f, tree.distance(glm::vec3(point)));
  }
}

TEST(SurfaceWalk, looksAtEveryTriangleForTheNearest) {
  const NodeMesh mesh = test::makeTangle(200, 300, 8);
  const TriangleTree tree(mesh);
  const SurfaceWalk walk(mesh);
  std::mt19937 random(5);
  for (int i = 0; i < 500; ++i) {
    const glm::uvec3 point(random() % 64, random() % 64, random() % 64);
    EXPECT_NEAR(walk.nearestOfAll(glm::vec3(point), TriangleTree::kNothing).distance,
                tree.distance(glm::vec3(point)), 1e-3);
  }
}

TEST(SurfaceWalk, endsAtAPlaceAtTheGivenDistanceEvenOnSlivers) {
  std::mt19937 random(6);
  for (int i = 0; i < 2000; ++i) {
    NodeMesh sliver = test::nodeOf(test::makeGrid(1, 1));
    sliver.triangles.resize(1);
    const auto at = [&](uint32_t corner) -> PositionCode& {
      return sliver.positions[sliver.wedge_position[sliver.triangles[0][static_cast<int>(corner)]]];
    };
    const auto aside = [&] { return static_cast<uint32_t>(random() % 64); };
    at(0) = packPosition({100 + aside(), 100 + aside(), 100 + aside()});
    at(1) = packPosition({30000 + aside(), 27000 + aside(), 32000 + aside()});
    at(2) = packPosition({15000 + aside(), 13500 + aside(), 16000 + aside()});
    const glm::vec3 point(15000 + aside(), 13500 + aside(), 16000 + aside());
    const uint32_t start = sliver.wedge_position[sliver.triangles[0].x];
    const SurfaceWalk::Place place = SurfaceWalk(sliver).placeOf(point, start);
    glm::dvec3 foot(0);
    for (uint32_t k = 0; k < 3; ++k)
      foot += static_cast<double>(place.shares[static_cast<int>(k)]) * glm::dvec3(unpackPosition(at(k)));
    EXPECT_NEAR(place.distance, glm::distance(foot, glm::dvec3(point)), 0.05);
  }
}

TEST(SurfaceWalk, staysOnThePointsSideOfAPlate) {
  NodeMesh plate;
  plate.positions = {packPosition({100, 100, 100}), packPosition({160, 100, 100}),
                     packPosition({160, 160, 100}), packPosition({260, 100, 100}),
                     packPosition({300, 0, 90}),    packPosition({300, 250, 90})};
  plate.wedge_position = {0, 1, 2, 3, 4, 5};
  plate.lca_depth.assign(6, kNeverLocked);
  plate.triangles = {{0, 1, 2}, {1, 3, 2}, {0, 5, 4}};  // two at the front; the back is around the boundary
  const SurfaceWalk::Place place = SurfaceWalk(plate).placeOf({163, 115, 100}, 0);
  EXPECT_EQ(place.triangle, 1u);
  EXPECT_FLOAT_EQ(place.distance, 0);
}

TEST(SurfaceWalk, findsEachPositionAtACornerOfATriangle) {
  const NodeMesh mesh = test::nodeOf(test::makeSphere(12, 8));
  const SurfaceWalk walk(mesh);
  for (uint32_t i = 0; i < mesh.positions.size(); ++i) {
    const SurfaceWalk::Place place = walk.placeAt(i);
    glm::vec3 at(0);
    for (int k = 0; k < 3; ++k)
      at += place.shares[k] *
            glm::vec3(unpackPosition(mesh.positions[mesh.wedge_position[mesh.triangles[place.triangle][k]]]));
    EXPECT_EQ(at, glm::vec3(unpackPosition(mesh.positions[i])));
    EXPECT_EQ(place.distance, 0);
  }
}

TEST(SurfaceWalk, findsAChainToAVertexFromAnyOfItsTriangles) {
  const NodeMesh mesh = test::nodeOf(test::makeGrid(8, 8));
  const SurfaceWalk walk(mesh);
  const auto cornersOf = [&](uint32_t t) {
    const glm::u32vec3& wedges = mesh.triangles[t];
    return std::array<uint32_t, 3>{mesh.wedge_position[wedges.x], mesh.wedge_position[wedges.y],
                                   mesh.wedge_position[wedges.z]};
  };
  const auto at = [&](uint32_t position) { return glm::vec3(unpackPosition(mesh.positions[position])); };
  const uint32_t first = 0;
  const auto [a, b, c] = cornersOf(first);
  const glm::vec3 from = (at(a) + at(b) + at(c)) / 3.f;
  size_t ends = 0;
  for (uint32_t last = 0; last < mesh.triangles.size(); ++last)
    for (const uint32_t vertex : cornersOf(last)) {
      if (glm::distance(at(vertex), from) > 1.5f * glm::distance(at(a), at(b))) continue;
      TriangleChain chain;
      ASSERT_TRUE(walk.chainAlong({from, at(vertex)}, first, last, 0, chain)) << last;
      const uint32_t end = chain.triangles[chain.edge_count];
      EXPECT_EQ(walk.squaredDistance(at(vertex), end), 0) << last;
      ++ends;
    }
  EXPECT_GT(ends, 12);
}

TEST(SurfaceWalk, isInfinitelyFarWithoutTriangles) {
  NodeMesh mesh = test::nodeOf(test::makeGrid(4, 4));
  mesh.triangles.clear();
  EXPECT_TRUE(std::isinf(SurfaceWalk(mesh).distance({1, 2, 3}, 0, 0)));
}

}  // namespace
}  // namespace lode::ingest
