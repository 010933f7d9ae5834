#include "common/node_key.h"

#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace lode {
namespace {

NodeKey randomKey(std::mt19937& random, int depth) {
  NodeKey key = kRootKey;
  for (int i = 0; i < depth; ++i) key = key.child(random() % 8);
  return key;
}

TEST(NodeKey, rootIsValidAtDepthZero) {
  EXPECT_TRUE(kRootKey.valid());
  EXPECT_EQ(kRootKey.depth(), 0);
}

TEST(NodeKey, childKnowsItsParentAndOctant) {
  std::mt19937 random(1);
  for (int depth = 0; depth < kMaxDepth; ++depth)
    for (unsigned octant = 0; octant < 8; ++octant) {
      const NodeKey key = randomKey(random, depth);
      const NodeKey child = key.child(octant);
      EXPECT_TRUE(child.valid());
      EXPECT_EQ(child.depth(), depth + 1);
      EXPECT_EQ(child.parent(), key);
      EXPECT_EQ(child.octant(), octant);
    }
}

TEST(NodeKey, keysBelowTheDeepestLevelAreInvalid) {
  std::mt19937 random(2);
  const NodeKey deepest = randomKey(random, kMaxDepth);
  EXPECT_TRUE(deepest.valid());
  EXPECT_FALSE(deepest.child(0).valid());
}

TEST(NodeKey, keysWithoutALeadingOneInPlaceAreInvalid) {
  for (const uint64_t value : {0ull, 2ull, 3ull, 4ull, 7ull, 16ull, ~0ull})
    EXPECT_FALSE(NodeKey{value}.valid()) << value;
}

TEST(NodeKey, containsItselfAndItsDescendantsOnly) {
  std::mt19937 random(3);
  const NodeKey key = randomKey(random, 5);
  EXPECT_TRUE(key.contains(key));
  EXPECT_TRUE(key.contains(key.child(3).child(7)));
  EXPECT_FALSE(key.contains(key.parent()));
  EXPECT_FALSE(key.child(1).contains(key.child(2).child(1)));
}

TEST(NodeKey, ordersCoarseBeforeFineAndSiblingsTogether) {
  EXPECT_LT(kRootKey.child(7), kRootKey.child(0).child(0));
  EXPECT_LT(kRootKey.child(2).child(7), kRootKey.child(3).child(0));
}

TEST(NodeKey, commonAncestorIsTheDeepestThatContainsBoth) {
  std::mt19937 random(4);
  for (int i = 0; i < 1000; ++i) {
    const NodeKey top = randomKey(random, static_cast<int>(random() % 6));
    NodeKey a = top, b = top;
    for (auto n = random() % 6; n > 0; --n) a = a.child(random() % 8);
    for (auto n = random() % 6; n > 0; --n) b = b.child(random() % 8);
    const NodeKey common = commonAncestor(a, b);
    ASSERT_TRUE(common.contains(a) && common.contains(b));
    for (unsigned octant = 0; octant < 8; ++octant)
      ASSERT_FALSE(common.child(octant).contains(a) && common.child(octant).contains(b));
    ASSERT_EQ(common, commonAncestor(b, a));
  }
}

}  // namespace
}  // namespace lode
