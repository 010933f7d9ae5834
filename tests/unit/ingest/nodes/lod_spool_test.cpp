#include "server/ingest/nodes/lod_spool.h"

#include <gtest/gtest.h>

#include "server/ingest/disk/temporary_folder.h"

namespace lode::ingest {
namespace {

SimplifiedMesh lodOf(uint32_t positions, bool has_attributes) {
  SimplifiedMesh lod;
  lod.is_clustered = positions % 2 == 0;
  if (has_attributes) lod.mesh.attributes.bits = AttributeSet::kColour;
  for (uint32_t i = 0; i < positions; ++i) {
    lod.mesh.positions.push_back(packPosition({i, 2 * i, 7}));
    lod.mesh.lca_depth.push_back(static_cast<uint8_t>(i % 5));
    lod.mesh.wedge_position.push_back(i);
    lod.remap.insert(lod.remap.end(), {i, kVanished});
    VertexAttributes attributes;
    attributes.colour = glm::u8vec4(static_cast<uint8_t>(i));
    if (has_attributes) lod.mesh.wedge_attributes.push_back(attributes);
    if (i >= 2) lod.mesh.triangles.emplace_back(i - 2, i - 1, i);
  }
  return lod;
}

void expectSame(const SimplifiedMesh& a, const SimplifiedMesh& b) {
  EXPECT_EQ(a.mesh.attributes.bits, b.mesh.attributes.bits);
  EXPECT_EQ(a.mesh.positions, b.mesh.positions);
  EXPECT_EQ(a.mesh.lca_depth, b.mesh.lca_depth);
  EXPECT_EQ(a.mesh.wedge_position, b.mesh.wedge_position);
  EXPECT_EQ(a.mesh.wedge_attributes, b.mesh.wedge_attributes);
  EXPECT_EQ(a.mesh.triangles, b.mesh.triangles);
  EXPECT_EQ(a.remap, b.remap);
  EXPECT_EQ(a.is_clustered, b.is_clustered);
}

TEST(LodSpool, readsBackEachLod) {
  const TemporaryFolder folder(::testing::TempDir());
  LodSpool shelf(folder.file("lods"));
  const std::vector<SimplifiedMesh> lods{lodOf(9, true), lodOf(6, false), lodOf(0, true), lodOf(3, true)};
  for (const SimplifiedMesh& lod : lods) shelf.put(lod);
  ASSERT_EQ(shelf.size(), lods.size());
  for (size_t i = 0; i < lods.size(); ++i) expectSame(shelf.read(i), lods[i]);
}

}  // namespace
}  // namespace lode::ingest
