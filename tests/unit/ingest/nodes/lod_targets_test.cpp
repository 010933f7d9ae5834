#include "server/ingest/nodes/lod_targets.h"

#include <gtest/gtest.h>

#include "common/limits.h"

namespace lode::ingest {
namespace {

constexpr size_t kTargetCapacity = 16384;

TEST(LodTargets, halveDownToTheNodesCapacity) {
  const LodRule rule{
      .depth = 5, .locked = 100, .original_triangles = 1 << 20, .triangles_per_node = kTargetCapacity};
  EXPECT_EQ(lodTargets(40000, rule), (std::vector<size_t>{20000, 10000}));
}

TEST(LodTargets, stopAtEightTimesTheLockedVertices) {
  const LodRule rule{
      .depth = 5, .locked = 3000, .original_triangles = 1 << 20, .triangles_per_node = kTargetCapacity};
  EXPECT_EQ(lodTargets(40000, rule), (std::vector<size_t>{20000}));
}

TEST(LodTargets, stopAtTwelveTimesTheLockedVerticesBelowTheRootOfALargeModel) {
  LodRule rule{.depth = 1,
               .locked = 3000,
               .original_triangles = 16 * kTargetCapacity,
               .triangles_per_node = kTargetCapacity};
  EXPECT_EQ(lodTargets(100000, rule), (std::vector<size_t>{70710, 50000, 35355}));
  --rule.original_triangles;
  EXPECT_EQ(lodTargets(100000, rule), (std::vector<size_t>{50000, 25000, 12500}));
}

TEST(LodTargets, stopAtFourTimesTheLockedVerticesIfTheseAreVeryMany) {
  const LodRule rule{.depth = 5,
                     .locked = 40000,
                     .original_triangles = uint64_t{1} << 30,
                     .triangles_per_node = kTargetCapacity};
  const std::vector<size_t> targets = lodTargets(700000, rule);
  EXPECT_LE(targets.back(), 4 * rule.locked);
  EXPECT_GT(targets[targets.size() - 2], 4 * rule.locked);
}

TEST(LodTargets, stopAt131072IfEightTimesTheLockedVerticesIsMore) {
  const LodRule rule{.depth = 5,
                     .locked = 20000,
                     .original_triangles = uint64_t{1} << 30,
                     .triangles_per_node = kTargetCapacity};
  EXPECT_EQ(lodTargets(520000, rule), (std::vector<size_t>{260000, 130000}));
}

TEST(LodTargets, stopAtEightCapacitiesIfTwelveTimesTheLockedVerticesIsMore) {
  const LodRule rule{.depth = 1, .locked = 900, .original_triangles = 1 << 20, .triangles_per_node = 512};
  EXPECT_EQ(lodTargets(16000, rule).back(), 4000u);
  EXPECT_EQ(mostTriangles(rule), 4096u);
}

TEST(LodTargets, stopAt16384ForSmallCapacitiesAwayFromTheRoot) {
  LodRule rule{.depth = 2, .locked = 900, .original_triangles = 1 << 20, .triangles_per_node = 512};
  EXPECT_EQ(mostTriangles(rule), 8 * 900u);
  rule.locked = 3000;
  EXPECT_EQ(mostTriangles(rule), 1u << 14);
}

TEST(LodTargets, endBelowTheAnnouncedMaximum) {
  for (const size_t locked : {0u, 700u, 3000u, 20000u, 60000u}) {
    for (const size_t capacity : {size_t{512}, kTargetCapacity}) {
      const LodRule rule{
          .depth = 1, .locked = locked, .original_triangles = 1 << 20, .triangles_per_node = capacity};
      EXPECT_LE(lodTargets(600000, rule).back(), mostTriangles(rule)) << locked << ", " << capacity;
    }
  }
}

TEST(LodTargets, leaveANodeThatIsNearlyAllBorderMoreThanItsBorder) {
  const LodRule rule{
      .depth = 5, .locked = 90, .original_triangles = 1 << 20, .triangles_per_node = kTargetCapacity};
  EXPECT_EQ(lodTargets(141, rule), (std::vector<size_t>{107}));
}

TEST(LodTargets, takeStepsOfTheSquareRootOfTwoNearTheRootOfALargeModel) {
  const LodRule rule{.depth = 2, .locked = 0, .original_triangles = 16 * 9000, .triangles_per_node = 9000};
  EXPECT_EQ(lodTargets(20000, rule), (std::vector<size_t>{14142, 10000, 7071}));
}

TEST(LodTargets, halveNearTheRootOfASmallModel) {
  const LodRule rule{
      .depth = 2, .locked = 0, .original_triangles = 16 * 9000 - 1, .triangles_per_node = 9000};
  EXPECT_EQ(lodTargets(20000, rule), (std::vector<size_t>{10000, 5000}));
}

TEST(LodTargets, leaveOutLodsAboveTheLimitOfAStore) {
  constexpr size_t kTooMany = 8 * size_t{kMaxLodTriangles};
  const LodRule rule{.depth = 5, .original_triangles = kTooMany, .triangles_per_node = 300000};
  EXPECT_EQ(lodTargets(kTooMany, rule), (std::vector<size_t>{1 << 20, 1 << 19, 1 << 18}));
  for (size_t triangles = kTooMany; triangles > kMaxLodTriangles; triangles /= 3)
    for (const int depth : {0, 1, 5})
      EXPECT_LE(lodTargets(triangles, {.depth = depth, .triangles_per_node = 300000}).front(),
                kMaxLodTriangles);
}

TEST(LodTargets, reachTheLimitOfAStoreDespiteLockedVertices) {
  const LodRule rule{.depth = 5,
                     .locked = 700000,
                     .original_triangles = uint64_t{1} << 30,
                     .triangles_per_node = kTargetCapacity};
  const std::vector<size_t> targets = lodTargets(4 * size_t{kMaxLodTriangles}, rule);
  ASSERT_EQ(targets.size(), 1u);
  EXPECT_LE(targets[0], kMaxLodTriangles);
  EXPECT_GT(targets[0], 700000u);
}

TEST(LodTargets, alwaysReduceOnce) {
  const LodRule rule{
      .depth = 5, .locked = 0, .original_triangles = 100, .triangles_per_node = kTargetCapacity};
  EXPECT_EQ(lodTargets(100, rule), (std::vector<size_t>{50}));
}

TEST(LodTargets, goDownTo512AtTheRoot) {
  const std::vector<size_t> targets =
      lodTargets(16000, {.original_triangles = 16000, .triangles_per_node = kTargetCapacity});
  EXPECT_LE(targets.back(), kRootTriangles);
  EXPECT_GT(targets[targets.size() - 2], kRootTriangles);
}

TEST(LodTargets, areEmptyForASmallRootThatIsALeaf) {
  const LodRule rule{.is_leaf = true, .original_triangles = 512, .triangles_per_node = kTargetCapacity};
  EXPECT_TRUE(lodTargets(512, rule).empty());
}

TEST(FarLodTargets, halveDownToAQuarterOfTheCapacity) {
  const LodRule rule{.depth = 2,
                     .locked = 0,
                     .original_triangles = 8 * kTargetCapacity,
                     .triangles_per_node = kTargetCapacity};
  EXPECT_EQ(farLodTargets(16000, rule), (std::vector<size_t>{8000, 4000}));
  EXPECT_TRUE(farLodTargets(4096, rule).empty());
}

TEST(FarLodTargets, stopAtTwoTrianglesPerLockedVertex) {
  const LodRule rule{.depth = 2,
                     .locked = 4000,
                     .original_triangles = 8 * kTargetCapacity,
                     .triangles_per_node = kTargetCapacity};
  EXPECT_EQ(farLodTargets(32000, rule), (std::vector<size_t>{16000, 8000}));
}

TEST(FarLodTargets, leaveANodeThatIsNearlyAllBorderMoreThanItsBorder) {
  const LodRule rule{.depth = 2,
                     .locked = 9000,
                     .original_triangles = 8 * kTargetCapacity,
                     .triangles_per_node = kTargetCapacity};
  EXPECT_EQ(farLodTargets(19200, rule), (std::vector<size_t>{12400}));
}

TEST(FarLodTargets, areEmptyForTheRootAndCloseToTheLeaves) {
  LodRule rule{
      .depth = 2, .original_triangles = 8 * kTargetCapacity - 1, .triangles_per_node = kTargetCapacity};
  EXPECT_TRUE(farLodTargets(16000, rule).empty());
  rule = {.depth = 0, .original_triangles = 8 * kTargetCapacity, .triangles_per_node = kTargetCapacity};
  EXPECT_TRUE(farLodTargets(16000, rule).empty());
}

TEST(LodTargets, reduceASmallRootThatIsNoLeaf) {
  EXPECT_EQ(lodTargets(300, {.original_triangles = 300, .triangles_per_node = 64}),
            (std::vector<size_t>{212}));
}

}  // namespace
}  // namespace lode::ingest
