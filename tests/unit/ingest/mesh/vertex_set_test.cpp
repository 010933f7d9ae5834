#include "server/ingest/mesh/vertex_set.h"

#include <random>
#include <set>

#include <gtest/gtest.h>

namespace lode::ingest {
namespace {

TEST(VertexSet, ranksMembersInRisingOrder) {
  std::mt19937 random(3);
  VertexSet set(5000);
  std::set<uint64_t> expected;
  for (int i = 0; i < 1500; ++i) {
    const uint64_t vertex = random() % 5000;
    EXPECT_EQ(set.add(vertex), expected.insert(vertex).second);
  }
  EXPECT_EQ(set.countRanks(), expected.size());
  uint64_t rank = 0;
  for (const uint64_t vertex : expected) EXPECT_EQ(set.rank(vertex), rank++);
}

TEST(VertexSet, isEmptyAfterClearing) {
  VertexSet set(100);
  set.add(99);
  set.clear();
  EXPECT_FALSE(set.contains(99));
  EXPECT_EQ(set.countRanks(), 0u);
}

}  // namespace
}  // namespace lode::ingest
