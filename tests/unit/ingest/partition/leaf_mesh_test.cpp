#include "server/ingest/partition/leaf_mesh.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "common/error.h"
#include "tests/support/node_meshes.h"

namespace lode::ingest {
namespace {

TEST(LeafMesh, isReadAsItWasNoted) {
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

TEST(LeafMesh, isRefusedWhereItNamesWhatIsNotThere) {
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

TEST(LeafMesh, listsTheVerticesOfEdgesNotUsedTwiceAsBorder) {
  // A square of four triangles about its centre: the centre alone is inside.
  std::vector<std::byte> records;
  const PositionCode corner[] = {packPosition({0, 0, 0}), packPosition({8, 0, 0}), packPosition({8, 8, 0}),
                                 packPosition({0, 8, 0})};
  for (int k = 0; k < 4; ++k) {
    SoupTriangle triangle{{corner[k], corner[(k + 1) % 4], packPosition({4, 4, 0})}, {}};
    records.resize(records.size() + kSoupPositionBytes);
    storeSoup(triangle, std::span(records).last(kSoupPositionBytes));
  }
  MeshWelder welder;
  const NodeMesh mesh = weldSoup(records, {}, welder);
  ASSERT_EQ(mesh.positions.size(), 5u);
  std::vector<PositionCode> border;
  for (const uint32_t position : findBorder(mesh)) border.push_back(mesh.positions[position]);
  EXPECT_EQ(border.size(), 4u);
  EXPECT_EQ(std::count(border.begin(), border.end(), packPosition({4, 4, 0})), 0);
}

TEST(LeafMesh, listsTheVerticesOfEdgesThatMoreThanTwoTrianglesUseAsBorder) {
  // A closed surface with a fin on one of its edges.
  NodeMesh mesh = test::nodeOf(test::makeSphere(12, 8));
  ASSERT_TRUE(findBorder(mesh).empty());
  const glm::u32vec3 t = mesh.triangles[0];
  mesh.wedge_position.push_back(static_cast<uint32_t>(mesh.positions.size()));
  mesh.positions.push_back(packPosition({1, 2, 3}));
  const auto tip = static_cast<uint32_t>(mesh.wedge_position.size() - 1);
  mesh.triangles.emplace_back(t.x, t.y, tip);
  EXPECT_EQ(findBorder(mesh).size(), 3u);
  mesh.triangles.emplace_back(t.y, t.x,
                              tip);  // the fin's other side: its rims are used twice, its foot 4 times
  EXPECT_EQ(findBorder(mesh).size(), 2u);
}

}  // namespace
}  // namespace lode::ingest
