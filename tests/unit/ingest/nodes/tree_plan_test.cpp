#include "server/ingest/nodes/tree_plan.h"

#include <gtest/gtest.h>

namespace lode::ingest {
namespace {

TEST(TreePlan, isTheRootAloneIfItIsALeaf) {
  const TreePlan plan({kRootKey});
  ASSERT_EQ(plan.size(), 1u);
  EXPECT_TRUE(plan.isRoot(0));
  EXPECT_TRUE(plan.isLeaf(0));
  EXPECT_TRUE(plan.children(0).empty());
}

TEST(TreePlan, numbersNodesAfterTheirChildrenInOctantOrder) {
  const NodeKey second = kRootKey.child(2), deep = second.child(5);
  const std::vector<NodeKey> leaves{kRootKey.child(0), second.child(1), deep.child(0),
                                    deep.child(7),     second.child(6), kRootKey.child(7)};
  const TreePlan plan(leaves);
  ASSERT_EQ(plan.size(), 9u);
  size_t next_leaf = 0;
  for (uint32_t number = 0; number < plan.size(); ++number) {
    const std::vector<uint32_t> children = plan.children(number);
    EXPECT_EQ(plan.isLeaf(number), children.empty());
    if (plan.isLeaf(number)) {
      EXPECT_EQ(plan.key(number), leaves[next_leaf]);
      EXPECT_EQ(plan.leaf(number), next_leaf++);
    }
    for (size_t i = 0; i < children.size(); ++i) {
      EXPECT_LT(children[i], number);
      EXPECT_EQ(plan.parent(children[i]), number);
      EXPECT_EQ(plan.key(children[i]).parent(), plan.key(number));
      if (i > 0) {
        EXPECT_LT(plan.key(children[i - 1]), plan.key(children[i]));
      }
    }
  }
  EXPECT_EQ(next_leaf, leaves.size());
  EXPECT_EQ(plan.key(8), kRootKey);
  EXPECT_EQ(plan.children(8).size(), 3u);
}

}  // namespace
}  // namespace lode::ingest
