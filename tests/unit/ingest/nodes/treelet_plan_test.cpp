#include "server/ingest/nodes/treelet_plan.h"

#include <algorithm>
#include <numeric>
#include <set>

#include <gtest/gtest.h>

#include "server/ingest/nodes/task_plan.h"
#include "tests/unit/ingest/nodes/leaves.h"

namespace lode::ingest {
namespace {

using test::digest;
using test::LeavesOfTree;

TEST(TreeletPlan, putsEachNodeIntoOneTreeletBelowItsRoot) {
  const LeavesOfTree leaves(3);
  const TreePlan tree(leaves.keys);
  const TreeletPlan treelets(tree, leaves.marks, digest("settings"));
  uint32_t nodes = 0;
  for (uint32_t i = 0; i < treelets.size(); ++i) {
    nodes += treelets[i].nodes;
    EXPECT_EQ(treelets.treeletOf(treelets[i].root), i);
  }
  EXPECT_EQ(nodes, tree.size());
  for (uint32_t node = 0; node < tree.size(); ++node) {
    const NodeKey root = tree.key(treelets[treelets.treeletOf(node)].root);
    EXPECT_TRUE(root.contains(tree.key(node)));
  }
}

TEST(TreeletPlan, beginsATreeletAtEachNodeWithMoreThanTwoLeaves) {
  const NodeKey two = kRootKey.child(0), three = kRootKey.child(1);
  const TreePlan tree({two.child(0), two.child(7), three.child(1), three.child(2), three.child(3)});
  const TreeletPlan treelets(tree, std::vector<LeafOfTreelet>(5), digest("settings"));
  ASSERT_EQ(treelets.size(), 2u);
  EXPECT_EQ(tree.key(treelets[0].root), three);
  EXPECT_EQ(treelets[0].nodes, 4u);
  EXPECT_EQ(tree.key(treelets[1].root), kRootKey);
  EXPECT_EQ(treelets[1].nodes, 4u) << "two leaves, their parent and the root";
}

TEST(TreeletPlan, isOneTreeletOfOneNodeIfTheRootIsALeaf) {
  const TreePlan tree({kRootKey});
  const TreeletPlan treelets(tree, std::vector<LeafOfTreelet>{{digest("leaf"), 7}}, digest("settings"));
  ASSERT_EQ(treelets.size(), 1u);
  EXPECT_EQ(treelets[0].nodes, 1u);
  EXPECT_EQ(treelets[0].leaf_bytes, 7u);
}

TEST(TreeletPlan, sumsTheBytesOfAllLeavesBelow) {
  const LeavesOfTree leaves(3);
  const TreePlan tree(leaves.keys);
  const TreeletPlan treelets(tree, leaves.marks, digest("settings"));
  uint64_t bytes = 0;
  for (const LeafOfTreelet& leaf : leaves.marks) bytes += leaf.bytes;
  EXPECT_EQ(treelets.all().back().leaf_bytes, bytes);
}

/// Returns the names that differ between two models.
size_t differentNames(const LeavesOfTree& a, const LeavesOfTree& b) {
  const TreePlan tree_a(a.keys), tree_b(b.keys);
  const TreeletPlan treelets_a(tree_a, a.marks, digest("s")), treelets_b(tree_b, b.marks, digest("s"));
  std::set<Digest> names;
  for (const Treelet& treelet : treelets_a.all()) names.insert(treelet.name);
  return static_cast<size_t>(std::ranges::count_if(
      treelets_b.all(), [&](const Treelet& treelet) { return !names.contains(treelet.name); }));
}

TEST(TreeletPlan, renamesOnlyTheTreeletsFromAChangedLeafToTheRoot) {
  const LeavesOfTree before(4);
  EXPECT_EQ(differentNames(before, before), 0u);
  for (const size_t leaf : {0u, 1234u, 4095u}) {
    LeavesOfTree after = before;
    after.marks[leaf].digest = digest("edited");
    EXPECT_EQ(differentNames(before, after), 4u) << leaf;
  }
}

TEST(TreeletPlan, renamesATreeletIfALeafIsMissing) {
  LeavesOfTree before(3), after = before;
  after.keys.erase(after.keys.begin() + 100);
  after.marks.erase(after.marks.begin() + 100);
  EXPECT_EQ(differentNames(before, after), 3u);
}

TEST(TreeletPlan, givesAllTreeletsOtherNamesIfTheSettingsDiffer) {
  const LeavesOfTree leaves(3);
  const TreePlan tree(leaves.keys);
  const TreeletPlan a(tree, leaves.marks, digest("a")), b(tree, leaves.marks, digest("b"));
  for (uint32_t i = 0; i < a.size(); ++i) EXPECT_NE(a[i].name, b[i].name);
}

TEST(TreeletPlan, namesNoTwoTreeletsAlike) {
  LeavesOfTree leaves(4);
  for (LeafOfTreelet& leaf : leaves.marks) leaf.digest = digest("the same mesh");
  const TreePlan tree(leaves.keys);
  const TreeletPlan treelets(tree, leaves.marks, digest("settings"));
  std::set<Digest> names;
  for (const Treelet& treelet : treelets.all()) names.insert(treelet.name);
  EXPECT_EQ(names.size(), treelets.size());
}

/// Returns the work of each task, and of `finish` as the last element.
std::vector<uint64_t> workOfTasks(const TreeletPlan& treelets, uint32_t tasks) {
  std::vector<uint64_t> work(tasks + 1);
  const std::vector<uint32_t> task_of = planTasks(treelets, tasks);
  for (uint32_t i = 0; i < treelets.size(); ++i) {
    uint64_t own = treelets[i].leaf_bytes;
    for (const uint32_t below : treelets.below(i)) own -= treelets[below].leaf_bytes;
    work.at(task_of[i]) += own;
  }
  return work;
}

TEST(TaskPlan, givesAWholeSubtreeToOneTask) {
  const LeavesOfTree leaves(4);
  const TreePlan tree(leaves.keys);
  const TreeletPlan treelets(tree, leaves.marks, digest("settings"));
  for (const uint32_t tasks : {1u, 2u, 3u, 7u, 16u, 1000u}) {
    const std::vector<uint32_t> task_of = planTasks(treelets, tasks);
    for (uint32_t i = 0; i + 1 < treelets.size(); ++i) {
      const uint32_t above = task_of[treelets.above(i)];
      EXPECT_TRUE(above == tasks || above == task_of[i]) << tasks << " tasks, treelet " << i;
    }
  }
}

TEST(TaskPlan, givesTasksSimilarWork) {
  const LeavesOfTree leaves(4);
  const TreePlan tree(leaves.keys);
  const TreeletPlan treelets(tree, leaves.marks, digest("settings"));
  for (const uint32_t tasks : {2u, 3u, 4u, 8u}) {
    std::vector<uint64_t> work = workOfTasks(treelets, tasks);
    EXPECT_EQ(work.back(), 0u) << "no leaf is left over for finish";
    work.pop_back();
    const double mean = std::accumulate(work.begin(), work.end(), 0.0) / tasks;
    EXPECT_LE(static_cast<double>(*std::ranges::max_element(work)), 1.25 * mean) << tasks;
  }
}

TEST(TaskPlan, givesASmallModelToTheFirstTask) {
  const LeavesOfTree leaves(1);  // one treelet
  const TreePlan tree(leaves.keys);
  const TreeletPlan treelets(tree, leaves.marks, digest("settings"));
  EXPECT_EQ(planTasks(treelets, 5), std::vector<uint32_t>{0});
}

}  // namespace
}  // namespace lode::ingest
