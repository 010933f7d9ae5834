
#include <gtest/gtest.h>

#include "server/ingest/measure/lod_input.h"
#include "tests/support/node_meshes.h"

namespace lode::ingest {
namespace {

constexpr uint8_t kLockDepth = 3;  ///< lca_depth of locked positions: deeper nodes lock them
constexpr float kGap = 7;

/// A triangle with its first two positions locked.
NodeMesh triangle() {
  NodeMesh mesh;
  mesh.positions = {packPosition({0, 0, 0}), packPosition({9, 0, 0}), packPosition({0, 9, 0})};
  mesh.lca_depth = {kLockDepth, kLockDepth, kNeverLocked};
  mesh.wedge_position = {0, 1, 2};
  mesh.triangles = {{0, 1, 2}};
  return mesh;
}

/// Position numbers of the references.
std::vector<glm::u32vec2> placesOf(const LodInput& input) {
  std::vector<glm::u32vec2> places;
  for (uint32_t i = 0; i < input.referenceCount(); ++i) places.push_back(input.reference(i).near);
  return places;
}

const std::vector<uint32_t> kUnmoved{0, 1, 2};

TEST(ReferenceBoundaries, areTheMeshsOwnBoundariesByDefault) {
  const LodInput input(triangle(), kLockDepth + 1);
  EXPECT_EQ(placesOf(input), (std::vector<glm::u32vec2>{{0, 2}, {1, 2}}));
  EXPECT_EQ(input.reference(1).from, input.mesh().positions[1]);
  EXPECT_EQ(input.reference(1).to, input.mesh().positions[2]);
}

TEST(ReferenceBoundaries, includeBoundariesThatWereBordersOfNodesBelow) {
  const LodInput below(triangle(), kLockDepth + 1);
  const LodInput input(triangle(), kLockDepth, {}, referencesIn(below, kUnmoved, 0, 9));
  EXPECT_EQ(placesOf(input), (std::vector<glm::u32vec2>{{0, 2}, {1, 2}, {0, 1}}));
}

TEST(ReferenceBoundaries, representTheBoundariesTheyBecame) {
  const ReferenceBoundary reference{packPosition({0, 1, 0}), packPosition({0, 8, 0}), {2, 0}};
  const LodInput input(triangle(), kLockDepth, {}, {{reference}, kGap});
  EXPECT_EQ(input.boundaries().size(), 3u);
  EXPECT_EQ(placesOf(input), (std::vector<glm::u32vec2>{{2, 0}, {0, 1}, {1, 2}}));
  EXPECT_EQ(input.reference(0).to, reference.to);
}

TEST(ReferenceBoundaries, stayAsTheyAreWhileTheirEndsMove) {
  const LodInput input(triangle(), kLockDepth + 1, {}, {{}, kGap});
  const ReferenceBoundaries references = referencesIn(input, std::vector<uint32_t>{4, kVanished, 4}, 99, 2);
  ASSERT_EQ(references.boundaries.size(), 2u);
  EXPECT_EQ(references.boundaries[0].near, glm::u32vec2(4, 4));
  EXPECT_EQ(references.boundaries[1].near, glm::u32vec2(kVanished, 4));
  EXPECT_EQ(references.boundaries[1].from, input.mesh().positions[1]);
  EXPECT_EQ(references.gap_steps, kGap);
}

TEST(ReferenceBoundaries, vanishWithBothEnds) {
  const LodInput input(triangle(), kLockDepth + 1);
  const ReferenceBoundaries references =
      referencesIn(input, std::vector<uint32_t>{0, kVanished, kVanished}, 0, 9);
  ASSERT_EQ(references.boundaries.size(), 1u);
  EXPECT_EQ(references.boundaries[0].near, glm::u32vec2(0, kVanished));
}

TEST(ReferenceBoundaries, areReplacedByTheLodsBoundariesAboveTheLimit) {
  const LodInput input(triangle(), kLockDepth + 1, {}, {{}, kGap});
  const ReferenceBoundaries references = referencesIn(input, kUnmoved, 99, 1);
  EXPECT_TRUE(references.boundaries.empty());
  EXPECT_EQ(references.gap_steps, 99);
}

}  // namespace
}  // namespace lode::ingest
