#include "server/ingest/nodes/rung_shelf.h"

#include <gtest/gtest.h>

#include "server/ingest/disk/temporary_folder.h"

namespace lode::ingest {
namespace {

SimplifiedMesh rungOf(uint32_t positions, bool has_attributes) {
  SimplifiedMesh rung;
  rung.is_clustered = positions % 2 == 0;
  if (has_attributes) rung.mesh.attributes.bits = AttributeSet::kColour;
  for (uint32_t i = 0; i < positions; ++i) {
    rung.mesh.positions.push_back(packPosition({i, 2 * i, 7}));
    rung.mesh.lca_depth.push_back(static_cast<uint8_t>(i % 5));
    rung.mesh.wedge_position.push_back(i);
    rung.became.insert(rung.became.end(), {i, kVanished});
    VertexAttributes attributes;
    attributes.colour = glm::u8vec4(static_cast<uint8_t>(i));
    if (has_attributes) rung.mesh.wedge_attributes.push_back(attributes);
    if (i >= 2) rung.mesh.triangles.emplace_back(i - 2, i - 1, i);
  }
  return rung;
}

void expectSame(const SimplifiedMesh& a, const SimplifiedMesh& b) {
  EXPECT_EQ(a.mesh.attributes.bits, b.mesh.attributes.bits);
  EXPECT_EQ(a.mesh.positions, b.mesh.positions);
  EXPECT_EQ(a.mesh.lca_depth, b.mesh.lca_depth);
  EXPECT_EQ(a.mesh.wedge_position, b.mesh.wedge_position);
  EXPECT_EQ(a.mesh.wedge_attributes, b.mesh.wedge_attributes);
  EXPECT_EQ(a.mesh.triangles, b.mesh.triangles);
  EXPECT_EQ(a.became, b.became);
  EXPECT_EQ(a.is_clustered, b.is_clustered);
}

TEST(RungShelf, givesEachRungBackAsItWas) {
  const TemporaryFolder folder(::testing::TempDir());
  RungShelf shelf(folder.file("rungs"));
  const std::vector<SimplifiedMesh> rungs{rungOf(9, true), rungOf(6, false), rungOf(0, true),
                                          rungOf(3, true)};
  for (const SimplifiedMesh& rung : rungs) shelf.put(rung);
  ASSERT_EQ(shelf.size(), rungs.size());
  for (size_t i = 0; i < rungs.size(); ++i) expectSame(shelf.read(i), rungs[i]);
}

}  // namespace
}  // namespace lode::ingest
