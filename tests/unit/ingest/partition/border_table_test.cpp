#include "server/ingest/partition/border_table.h"

#include <gtest/gtest.h>

#include "common/codec/surface_normals.h"
#include "common/error.h"
#include "common/limits.h"
#include "server/ingest/partition/leaf_mesh.h"

namespace lode::ingest {
namespace {

ListedFan listed(uint32_t leaf, glm::i64vec3 sum) {
  ListedFan fan;
  fan.leaf = leaf;
  fan.sum = sum;
  return fan;
}

/// Makes a fan with one end.
ListedFan listed(uint32_t leaf, glm::i64vec3 sum, PositionCode other, glm::vec3 direction) {
  ListedFan fan = listed(leaf, sum);
  fan.ends = 1;
  fan.other[0] = other;
  fan.direction[0] = direction;
  return fan;
}

const CreaseAngle kCrease(50);

TEST(BorderTable, locksSharedVerticesBelowTheLowestCommonAncestorOfTheirLeaves) {
  const TemporaryFolder folder(testing::TempDir());
  BorderTable table(folder, 1 << 20);
  // Leaves 0 and 1 are siblings at depth 2; leaf 2 is a shallower one at depth 1.
  const NodeKey leaves[] = {kRootKey.child(0).child(0), kRootKey.child(0).child(1), kRootKey.child(1)};
  table.add({10}, listed(0, {0, 0, 4}));
  table.add({10}, listed(1, {0, 0, 4}));
  table.add({20}, listed(0, {0, 0, 1}));
  table.add({20}, listed(2, {0, 0, 1}));
  table.add({30}, listed(0, {0, 0, 1}));
  table.join(leaves, kCrease);

  const auto first = table.read(0);
  ASSERT_EQ(first.size(), 2u);
  EXPECT_EQ(first[0].position, PositionCode{10});
  EXPECT_EQ(first[0].lca_depth, 1);
  EXPECT_EQ(first[1].position, PositionCode{20});
  EXPECT_EQ(first[1].lca_depth, 0);
  EXPECT_EQ(table.read(1).size(), 1u);
  EXPECT_EQ(table.read(2).size(), 1u);
}

TEST(BorderTable, countsLockedVerticesOnceInEachChildOfTheRoot) {
  const TemporaryFolder folder(testing::TempDir());
  BorderTable table(folder, 1 << 20);
  const NodeKey leaves[] = {kRootKey.child(0).child(0), kRootKey.child(0).child(1), kRootKey.child(5)};
  const glm::i64vec3 up{0, 0, 1};
  for (const uint32_t leaf : {0u, 1u}) table.add({10}, listed(leaf, up));      // within a child of the root
  for (const uint32_t leaf : {0u, 1u, 2u}) table.add({20}, listed(leaf, up));  // in two leaves of one child
  for (const uint32_t leaf : {1u, 2u}) table.add({30}, listed(leaf, up));
  table.add({40}, listed(2, up));
  table.join(leaves, kCrease);
  const std::array<uint64_t, 8> expected{2, 0, 0, 0, 0, 2, 0, 0};
  EXPECT_EQ(table.lockedBelowRoot(), expected);
  RecordWriter saved;
  table.save(saved);
  RecordReader reader(saved.bytes());
  EXPECT_EQ(BorderTable(folder, reader).lockedBelowRoot(), expected);
}

TEST(BorderTable, refusesMoreLockedVerticesThanAnLodCanHaveTriangles) {
  std::array<uint64_t, 8> locked{};
  locked[5] = kMaxLodTriangles;
  EXPECT_NO_THROW(refuseTooManyLocked(locked, "a.ply"));
  ++locked[5];
  EXPECT_THROW(refuseTooManyLocked(locked, "a.ply"), Error);
}

TEST(BorderTable, leavesVerticesThatOnlyOneLeafListsUnlocked) {
  const TemporaryFolder folder(testing::TempDir());
  BorderTable table(folder, 1 << 20);
  const NodeKey leaves[] = {kRootKey.child(0), kRootKey.child(1)};
  table.add({30}, listed(0, {1, 0, 0}));
  table.join(leaves, kCrease);
  EXPECT_TRUE(table.read(0).empty());
}

TEST(BorderTable, addsUpTheNormalsOfSmoothlyJoinedLeaves) {
  const TemporaryFolder folder(testing::TempDir());
  BorderTable table(folder, 1 << 20);
  const NodeKey leaves[] = {kRootKey.child(0), kRootKey.child(1)};
  table.add({30}, listed(0, {1000, 0, 0}, {31}, glm::normalize(glm::vec3(1, 0.3, 0))));
  table.add({30}, listed(1, {0, 1000, 0}, {31}, glm::normalize(glm::vec3(1, 0.4, 0))));
  table.join(leaves, kCrease);
  EXPECT_EQ(table.read(0).front().normal, normalOf({1, 1, 0}));
  EXPECT_EQ(table.read(1).front().normal, normalOf({1, 1, 0}));
}

TEST(BorderTable, keepsTheNormalsOnBothSidesOfACreaseApart) {
  const TemporaryFolder folder(testing::TempDir());
  BorderTable table(folder, 1 << 20);
  const NodeKey leaves[] = {kRootKey.child(0), kRootKey.child(1)};
  table.add({30}, listed(0, {1000, 0, 0}, {31}, {1, 0, 0}));
  table.add({30}, listed(1, {0, 1000, 0}, {31}, {0, 1, 0}));
  table.join(leaves, kCrease);
  EXPECT_EQ(table.read(0).front().normal, normalOf({1, 0, 0}));
  EXPECT_EQ(table.read(1).front().normal, normalOf({0, 1, 0}));
}

}  // namespace
}  // namespace lode::ingest
