#include "server/ingest/measure/boundary_gap.h"

#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

#include "tests/support/node_meshes.h"

namespace lode::ingest {
namespace {

constexpr float kRounding = 1.001f, kNegligible = 0.25f * kRounding;  // tolerances of boundaryGap()

NodeMesh meshOf(std::vector<glm::uvec2> points, std::vector<glm::u32vec3> triangles) {
  NodeMesh mesh;
  for (const glm::uvec2 point : points) {
    mesh.wedge_position.push_back(static_cast<uint32_t>(mesh.positions.size()));
    mesh.positions.push_back(packPosition({point, 0}));
  }
  mesh.lca_depth.assign(points.size(), kNeverLocked);
  mesh.triangles = std::move(triangles);
  return mesh;
}

/// A square. The middle of its upper boundary is raised by `bump`.
NodeMesh house(uint32_t bump) {
  return meshOf({{0, 0}, {100, 0}, {100, 100}, {50, 100 + bump}, {0, 100}},
                {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}});
}

/// A triangle whose lowest edge is divided by two points.
NodeMesh fan(glm::uvec2 second, glm::uvec2 third) {
  return meshOf({{0, 0}, second, third, {120, 0}, {60, 100}}, {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}});
}

/// An LOD with the same positions as its input, moved.
SimplifiedMesh moved(NodeMesh mesh) {
  std::vector<uint32_t> remap(mesh.positions.size());
  std::iota(remap.begin(), remap.end(), 0u);
  return {std::move(mesh), std::move(remap)};
}

TEST(BoundaryGap, measuresAShortenedBoundaryAgainstTheOriginal) {
  const LodInput input(house(40), 0);
  SimplifiedMesh flat{meshOf({{0, 0}, {100, 0}, {100, 100}, {0, 100}}, {{0, 1, 2}, {0, 2, 3}}),
                      {0, 1, 2, 3, 3}};
  const float of_middle =
      40 * 50 / std::hypot(40.f, 50.f);  // from the new boundary to either side of the roof
  const float gap = boundaryGap(flat, input);
  EXPECT_GE(gap, of_middle * 0.999f);
  EXPECT_LE(gap, of_middle * 1.021f * kRounding);
}

TEST(BoundaryGap, isZeroIfNothingMoved) {
  EXPECT_EQ(boundaryGap(moved(house(40)), LodInput(house(40), 0)), 0);
}

TEST(BoundaryGap, isZeroIfNothingIsLeft) {
  const SimplifiedMesh gone{{}, std::vector<uint32_t>(5, kVanished)};
  EXPECT_EQ(boundaryGap(gone, LodInput(house(40), 0)), 0);
}

TEST(BoundaryGap, includesTheGapOfItsReferences) {
  EXPECT_EQ(boundaryGap(moved(house(40)), LodInput(house(40), 0, {}, {{}, 3})), 3);
}

TEST(BoundaryGap, isMeasuredFromTheOriginalNotSummedOverLevels) {
  const LodInput original(house(40), 0);
  const SimplifiedMesh higher = moved(house(70)), lower = moved(house(50));
  const float up = boundaryGap(higher, original);
  const LodInput above(higher.mesh, 0, {}, referencesIn(original, higher.remap, up, 5));
  const float both = boundaryGap(lower, above);
  EXPECT_EQ(both, boundaryGap(lower, original));
  EXPECT_LT(both, up / 2);
}

TEST(BoundaryGap, looksAtBoundariesThatABoundaryHasMovedAlong) {
  const LodInput input(fan({40, 0}, {80, 0}), 0);
  EXPECT_LE(boundaryGap(moved(fan({110, 0}, {115, 0})), input), kNegligible);
}

TEST(BoundaryGap, isExactWithManyReferencesAtTheEnds) {
  // Points of a boundary with a tooth in its middle; one more point lies above the boundary.
  constexpr uint32_t kPoints = 400;
  std::vector<glm::uvec2> points;
  std::vector<glm::u32vec3> triangles;
  for (uint32_t i = 0; i < kPoints; ++i) points.emplace_back(10 * i, i == kPoints / 2 ? 30 : 0);
  points.emplace_back(5 * kPoints, 1000);
  for (uint32_t i = 0; i + 1 < kPoints; ++i) triangles.emplace_back(i, i + 1, kPoints);
  const LodInput input(meshOf(points, triangles), 0);
  std::vector<uint32_t> remap(kPoints + 1, 0);
  for (uint32_t i = kPoints / 2; i < kPoints; ++i) remap[i] = 1;
  remap[kPoints] = 2;
  const glm::uvec2 last(10 * (kPoints - 1), 0);
  const float gap = boundaryGap({meshOf({{0, 0}, last, points.back()}, {{0, 1, 2}}), remap}, input);
  const float below_tooth = 30 * 10 / std::hypot(30.f, 10.f);
  EXPECT_GE(gap, below_tooth * 0.999f);
  EXPECT_LE(gap, below_tooth * 1.021f * kRounding);
}

}  // namespace
}  // namespace lode::ingest
