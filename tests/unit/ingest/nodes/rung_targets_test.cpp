#include "server/ingest/nodes/rung_targets.h"

#include <gtest/gtest.h>

namespace lode::ingest {
namespace {

constexpr size_t kBudget = 16384;

TEST(RungTargets, halveUntilTheNodesBudget) {
  const RungRule rule{
      .depth = 5, .locked = 100, .original_triangles = 1 << 20, .triangles_per_node = kBudget};
  EXPECT_EQ(rungTargets(40000, rule), (std::vector<size_t>{20000, 10000}));
}

TEST(RungTargets, stopAtFourTimesTheLockedVertices) {
  const RungRule rule{
      .depth = 5, .locked = 6000, .original_triangles = 1 << 20, .triangles_per_node = kBudget};
  EXPECT_EQ(rungTargets(40000, rule), (std::vector<size_t>{20000}));
}

TEST(RungTargets, leaveANodeThatIsNearlyAllBorderMoreThanItsBorder) {
  const RungRule rule{.depth = 5, .locked = 90, .original_triangles = 1 << 20, .triangles_per_node = kBudget};
  EXPECT_EQ(rungTargets(141, rule), (std::vector<size_t>{107}));
}

TEST(RungTargets, takeStepsOfTheSquareRootOfTwoNearTheRootOfALargeModel) {
  const RungRule rule{.depth = 2, .locked = 0, .original_triangles = 16 * 9000, .triangles_per_node = 9000};
  EXPECT_EQ(rungTargets(20000, rule), (std::vector<size_t>{14142, 10000, 7071}));
}

TEST(RungTargets, halveNearTheRootOfASmallModel) {
  const RungRule rule{
      .depth = 2, .locked = 0, .original_triangles = 16 * 9000 - 1, .triangles_per_node = 9000};
  EXPECT_EQ(rungTargets(20000, rule), (std::vector<size_t>{10000, 5000}));
}

TEST(RungTargets, alwaysReduceOnce) {
  const RungRule rule{.depth = 5, .locked = 0, .original_triangles = 100, .triangles_per_node = kBudget};
  EXPECT_EQ(rungTargets(100, rule), (std::vector<size_t>{50}));
}

TEST(RungTargets, goDownTo512AtTheRoot) {
  const std::vector<size_t> targets =
      rungTargets(16000, {.original_triangles = 16000, .triangles_per_node = kBudget});
  EXPECT_LE(targets.back(), kRootTriangles);
  EXPECT_GT(targets[targets.size() - 2], kRootTriangles);
}

TEST(RungTargets, areNoneForASmallRootThatIsALeaf) {
  const RungRule rule{.is_leaf = true, .original_triangles = 512, .triangles_per_node = kBudget};
  EXPECT_TRUE(rungTargets(512, rule).empty());
}

TEST(RungTargets, reduceASmallRootThatIsNoLeaf) {
  EXPECT_EQ(rungTargets(300, {.original_triangles = 300, .triangles_per_node = 64}),
            (std::vector<size_t>{212}));
}

}  // namespace
}  // namespace lode::ingest
