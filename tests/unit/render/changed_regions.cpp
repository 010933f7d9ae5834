#include "client/render/residency/changed_regions.h"

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

namespace lode::test {
namespace {

using render::ChangedRegion;
using render::changedRegions;

const NodeKey kHere = kRootKey.child(3), kElsewhere = kRootKey.child(5);

TEST(ChangedRegions, matchANodeWithItsChildrenWhicheverOfThemArrive) {
  const std::vector above{kHere};
  const std::vector below{kHere.child(0), kHere.child(6), kHere.child(7).child(1)};
  EXPECT_EQ(changedRegions(above, below), (std::vector<ChangedRegion>{{kHere, {0}, {0, 1, 2}}}));
  EXPECT_EQ(changedRegions(below, above), (std::vector<ChangedRegion>{{kHere, {0, 1, 2}, {0}}}));
}

TEST(ChangedRegions, matchANodeWithItselfInAnotherLod) {
  EXPECT_EQ(changedRegions(std::vector{kHere}, std::vector{kHere}),
            (std::vector<ChangedRegion>{{kHere, {0}, {0}}}));
}

TEST(ChangedRegions, areSeparateForUnrelatedNodesAndMayHaveOneSideOnly) {
  const std::vector leaving{kElsewhere, kHere.child(2)};
  const std::vector arriving{kHere.child(2).child(4), kRootKey.child(7)};
  EXPECT_EQ(changedRegions(leaving, arriving),
            (std::vector<ChangedRegion>{
                {kHere.child(2), {1}, {0}}, {kElsewhere, {0}, {}}, {kRootKey.child(7), {}, {1}}}));
}

/// A random cover: splits each node with a random choice.
void cover(NodeKey node, std::mt19937& random, std::vector<NodeKey>& nodes) {
  if (node.depth() == 5 || random() % 3 == 0) {
    nodes.push_back(node);
    return;
  }
  for (unsigned octant = 0; octant < 8; octant += 3) cover(node.child(octant), random, nodes);
}

TEST(ChangedRegions, haveAllOfRandomCoversOnceAndTheShallowestOnTop) {
  std::mt19937 random(4);
  for (int round = 0; round < 200; ++round) {
    std::vector<NodeKey> before, after;
    cover(kRootKey, random, before);
    cover(kRootKey, random, after);
    std::ranges::shuffle(after, random);
    size_t leaving = 0, arriving = 0;
    for (const ChangedRegion& region : changedRegions(before, after)) {
      leaving += region.leaving.size();
      arriving += region.arriving.size();
      for (const uint32_t i : region.leaving) EXPECT_TRUE(region.node.contains(before[i]));
      for (const uint32_t i : region.arriving) EXPECT_TRUE(region.node.contains(after[i]));
      EXPECT_TRUE(before[region.leaving.at(0)] == region.node || after[region.arriving.at(0)] == region.node);
    }
    EXPECT_EQ(leaving, before.size());
    EXPECT_EQ(arriving, after.size());
  }
}

}  // namespace
}  // namespace lode::test
