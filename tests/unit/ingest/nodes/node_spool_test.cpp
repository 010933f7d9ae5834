#include "server/ingest/nodes/node_spool.h"

#include <gtest/gtest.h>

#include "server/ingest/nodes/built_node_record.h"
#include "tests/support/work_folder.h"

namespace lode::ingest {
namespace {

TEST(NodeSpool, readsBackNodesInKeyOrder) {
  const test::WorkFolder folder;
  NodeSpool spool({folder / "nodes"});
  for (const unsigned octant : {5u, 0u, 7u, 2u}) {
    Node node;
    node.key = kRootKey.child(octant);
    node.lods.resize(octant + 1);
    node.lods[0].triangles = 100 + octant;
    const std::vector<PayloadSpool::Place> payloads(octant + 1, {octant, octant});
    const NodeSpool::Place place = spool.append(node, payloads);
    const std::vector<std::byte> at_once = spool.read(place);
    RecordReader record(at_once);
    EXPECT_EQ(getFinishedNode(record).node, node);
  }
  NodeKey before;
  for (const NodeSpool::Place& place : spool.takeSorted()) {
    const std::vector<std::byte> bytes = spool.read(place);
    RecordReader record(bytes);
    const FinishedNode finished = getFinishedNode(record);
    EXPECT_LT(before, finished.node.key);
    before = finished.node.key;
    EXPECT_EQ(finished.node.lods.size(), before.octant() + 1u);
    EXPECT_EQ(finished.node.lods[0].triangles, 100u + before.octant());
    EXPECT_EQ(finished.payloads.back().offset, before.octant());
  }
}

}  // namespace
}  // namespace lode::ingest
