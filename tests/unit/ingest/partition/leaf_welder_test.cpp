#include "server/ingest/partition/leaf_welder.h"

#include <list>
#include <thread>

#include <gtest/gtest.h>

#include "server/ingest/mesh/soup_triangle.h"
#include "server/ingest/partition/leaf_mesh.h"
#include "tests/support/own_entries.h"

namespace lode::ingest {
namespace {

PositionCode at(uint32_t x, uint32_t y) { return packPosition({x, y, 0}); }

/// Makes two triangles that share the edge from (1, 0) to (0, 1), moved along x.
std::vector<std::byte> squareAt(uint32_t x) {
  const SoupTriangle triangles[] = {{{at(x, 0), at(x + 1, 0), at(x, 1)}, {}},
                                    {{at(x + 1, 0), at(x + 1, 1), at(x, 1)}, {}}};
  std::vector<std::byte> records(2 * kSoupPositionBytes);
  for (size_t t = 0; t < 2; ++t)
    storeSoup(triangles[t], std::span(records).subspan(t * kSoupPositionBytes, kSoupPositionBytes));
  return records;
}

/// Welds a row of squares, one per leaf.
std::vector<std::vector<BorderVertex>> bordersOfARow(unsigned threads) {
  const TemporaryFolder folder(testing::TempDir());
  BorderTable table(folder, 1 << 20);
  FixedHelpers helpers(threads - 1);
  LeafWelder welder(table, {}, CreaseAngle(50), helpers, [](std::span<const std::byte>, const Digest&) {});
  std::vector<NodeKey> leaves;
  for (uint32_t leaf = 0; leaf < 8; ++leaf) {
    leaves.push_back(kRootKey.child(leaf));
    welder.add(leaf, squareAt(leaf));
  }
  welder.finish();
  table.join(leaves, CreaseAngle(50));
  std::vector<std::vector<BorderVertex>> borders;
  for (uint32_t leaf = 0; leaf < 8; ++leaf) borders.push_back(table.read(leaf));
  return borders;
}

TEST(LeafWelder, listsTheVerticesThatLeavesShare) {
  const auto borders = bordersOfARow(1);
  EXPECT_EQ(borders[0].size(), 2u);
  EXPECT_EQ(borders[3].size(), 4u);
  EXPECT_EQ(borders[3][0].lca_depth, 0);
}

TEST(LeafWelder, findsTheSameOnSeveralThreads) {
  const auto here = bordersOfARow(1), there = bordersOfARow(3);
  for (size_t leaf = 0; leaf < here.size(); ++leaf) {
    ASSERT_EQ(here[leaf].size(), there[leaf].size());
    for (size_t i = 0; i < here[leaf].size(); ++i) {
      EXPECT_EQ(here[leaf][i].position, there[leaf][i].position);
      EXPECT_EQ(here[leaf][i].normal, there[leaf][i].normal);
    }
  }
}

std::vector<PositionCode> positionsOfARow(unsigned threads) {
  const TemporaryFolder folder(testing::TempDir());
  BorderTable table(folder, 1 << 20);
  FixedHelpers helpers(threads - 1);
  std::vector<PositionCode> positions;
  LeafWelder welder(table, {}, CreaseAngle(50), helpers, [&](std::span<const std::byte> mesh, const Digest&) {
    RecordReader record(mesh);
    const NodeMesh leaf = getLeaf(record, {});
    positions.insert(positions.end(), leaf.positions.begin(), leaf.positions.end());
  });
  for (uint32_t leaf = 0; leaf < 8; ++leaf) welder.add(leaf, squareAt(leaf));
  welder.finish();
  return positions;
}

TEST(LeafWelder, givesTheMeshesOfLeavesInTheirOrder) {
  const std::vector<PositionCode> positions = positionsOfARow(1);
  ASSERT_EQ(positions.size(), 8u * 4);
  EXPECT_EQ(unpackPosition(positions[4 * 5]).x, 5u);
  EXPECT_EQ(positionsOfARow(3), positions);
}

TEST(LeafWelder, endsItsThreadsWhenAbandoned) {
  const TemporaryFolder folder(testing::TempDir());
  BorderTable table(folder, 1 << 20);
  std::thread([] {}).join();  // the first thread also starts a thread of the thread sanitizer
  const size_t threads_before = test::ownEntries("task");
  {
    FixedHelpers helpers(8);
    std::list<LeafWelder> welders;
    for (int i = 0; i < 8; ++i)
      welders
          .emplace_back(table, AttributeSet(), CreaseAngle(50), helpers,
                        [](std::span<const std::byte>, const Digest&) {})
          .add(0, squareAt(0));
    EXPECT_GT(test::ownEntries("task"), threads_before);
  }
  EXPECT_LE(test::ownEntriesOnceDownTo(threads_before, "task"), threads_before);
}

}  // namespace
}  // namespace lode::ingest
