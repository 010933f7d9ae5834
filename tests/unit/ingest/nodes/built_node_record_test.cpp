#include "server/ingest/nodes/built_node_record.h"

#include <gtest/gtest.h>

#include "common/error.h"

namespace lode::ingest {
namespace {

/// A node of one triangle with two references: one of its sides, and an edge with a vanished end.
BuiltNode builtNode() {
  BuiltNode built;
  built.node.key = kRootKey.child(2);
  built.node.lods.resize(1);
  built.payloads.resize(1);
  built.coarsest.positions = {packPosition({0, 0, 0}), packPosition({9, 0, 0}), packPosition({0, 9, 0})};
  built.coarsest.triangles = {{0, 1, 2}};
  built.references.gap_steps = 7;
  built.references.boundaries = {{packPosition({1, 0, 0}), packPosition({8, 0, 0}), {0, 2}},
                                 {packPosition({2, 0, 0}), packPosition({3, 0, 0}), {kVanished, 1}}};
  built.samples = {{packPosition({4, 0, 0}), 5, 1}};
  return built;
}

BuiltNode readAgain(const BuiltNode& built) {
  RecordWriter record;
  putBuiltNode(record, built);
  RecordReader reader(record.bytes());
  return getBuiltNode(reader);
}

TEST(BuiltNodeRecord, readsBackItsReferenceBoundaries) {
  const BuiltNode built = builtNode(), again = readAgain(built);
  EXPECT_EQ(again.references.gap_steps, 7);
  ASSERT_EQ(again.references.boundaries.size(), 2u);
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(again.references.boundaries[i].from, built.references.boundaries[i].from);
    EXPECT_EQ(again.references.boundaries[i].to, built.references.boundaries[i].to);
    EXPECT_EQ(again.references.boundaries[i].near, built.references.boundaries[i].near);
  }
  EXPECT_EQ(again.samples.size(), 1u);
}

TEST(BuiltNodeRecord, isRefusedIfABoundaryRefersToAMissingPosition) {
  for (const glm::u32vec2 near : {glm::u32vec2(0, 3), glm::u32vec2(3, 0)}) {
    BuiltNode built = builtNode();
    built.references.boundaries[1].near = near;
    EXPECT_THROW(readAgain(built), Error);
  }
}

TEST(BuiltNodeRecord, isRefusedWhereItEndsTooEarly) {
  RecordWriter record;
  putBuiltNode(record, builtNode());
  for (size_t bytes = 0; bytes < record.bytes().size(); ++bytes) {
    RecordReader reader(record.bytes().first(bytes));
    EXPECT_THROW(getBuiltNode(reader), Error) << bytes;
  }
}

}  // namespace
}  // namespace lode::ingest
