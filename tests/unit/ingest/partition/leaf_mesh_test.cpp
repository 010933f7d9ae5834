#include "server/ingest/partition/leaf_mesh.h"

#include <gtest/gtest.h>

#include "common/error.h"
#include "tests/support/node_meshes.h"

namespace lode::ingest {
namespace {

TEST(LeafMesh, readsBackItsRecord) {
  for (const uint8_t bits : {uint8_t{0}, AttributeSet::kColour}) {
    Mesh grid = test::makeGrid(6, 6);
    grid.attributes.bits = bits;
    grid.vertex_attributes.assign(bits == 0 ? 0 : grid.positions.size(), {});
    const NodeMesh mesh = test::nodeOf(grid);
    RecordWriter noted;
    putLeaf(noted, mesh);
    RecordReader record(noted.bytes());
    const NodeMesh read = getLeaf(record, mesh.attributes);
    EXPECT_EQ(read.positions, mesh.positions);
    EXPECT_EQ(read.triangles, mesh.triangles);
    EXPECT_EQ(read.wedge_position, mesh.wedge_position);
    EXPECT_EQ(read.wedge_attributes, mesh.wedge_attributes);
    EXPECT_EQ(read.lca_depth, mesh.lca_depth);
  }
}

TEST(LeafMesh, isRefusedIfItRefersToMissingData) {
  NodeMesh mesh = test::nodeOf(test::makeGrid(6, 6));
  mesh.triangles[3].y = static_cast<uint32_t>(mesh.wedge_position.size());
  RecordWriter noted;
  putLeaf(noted, mesh);
  RecordReader record(noted.bytes());
  EXPECT_THROW(getLeaf(record, mesh.attributes), Error);
  RecordReader cut(noted.bytes().first(noted.bytes().size() - 1));
  EXPECT_THROW(getLeaf(cut, mesh.attributes), Error);
  NodeMesh coloured = mesh;
  coloured.attributes.bits = AttributeSet::kColour;
  coloured.triangles[3].y = 0;
  coloured.wedge_attributes.resize(coloured.wedge_position.size() - 1);
  RecordWriter fewer;
  putLeaf(fewer, coloured);
  RecordReader fewer_record(fewer.bytes());
  EXPECT_THROW(getLeaf(fewer_record, coloured.attributes), Error);
  mesh.triangles[3].y = mesh.triangles[3].x;
  RecordWriter flat;
  putLeaf(flat, mesh);
  RecordReader flat_record(flat.bytes());
  EXPECT_THROW(getLeaf(flat_record, mesh.attributes), Error);
}

}  // namespace
}  // namespace lode::ingest
