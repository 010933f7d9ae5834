#include "client/core/cache/mesh_cache.h"

#include <gtest/gtest.h>

#include "client/core/lod/triangle_clusters.h"

namespace lode::core {
namespace {

constexpr NodeKey kChild{8}, kGrandchild{64};

std::shared_ptr<const Mesh> meshOf(size_t triangles) {
  Mesh mesh;
  mesh.triangles.resize(triangles);
  return std::make_shared<const Mesh>(std::move(mesh));
}

const uint64_t kMeshBytes = meshBytes(*meshOf(100));

TEST(MeshCache, countsTheBytesOfItsMeshes) {
  MeshCache cache(1u << 30);
  cache.insert({kRootKey, 0}, meshOf(100));
  cache.insert({kChild, 0}, meshOf(100));
  cache.insert({kChild, 0}, meshOf(100));
  EXPECT_EQ(cache.bytes(), 2 * kMeshBytes);
  EXPECT_GE(kMeshBytes, 100 * sizeof(glm::u32vec3));
}

std::shared_ptr<const TextureFootprint> footprintOf(size_t tiles, size_t whole) {
  TextureFootprint footprint;
  footprint.tiles.resize(tiles);
  footprint.whole.resize(whole);
  return std::make_shared<const TextureFootprint>(std::move(footprint));
}

TEST(MeshCache, countsTheBytesOfFootprintsThatArriveLater) {
  const auto footprint = footprintOf(50, 3);
  const uint64_t footprint_bytes = footprintBytes(*footprint);
  EXPECT_GE(footprint_bytes, 50 * sizeof(TouchedTile) + 3 * sizeof(WornTexture));
  MeshCache cache(0);
  cache.insert({kChild, 0}, meshOf(100), footprint);
  EXPECT_EQ(cache.bytes(), kMeshBytes + footprint_bytes);
  cache.insert({kGrandchild, 0}, meshOf(100));
  cache.setFootprint({kGrandchild, 0}, footprint);
  cache.setFootprint({kGrandchild, 0}, footprint);
  EXPECT_EQ(cache.bytes(), 2 * (kMeshBytes + footprint_bytes));
  cache.use({}, {});
  cache.trim();
  EXPECT_EQ(cache.size(), 0u);
  EXPECT_EQ(cache.bytes(), 0u);
}

TEST(MeshCache, predictsTheBytesOfAMesh) {
  Mesh mesh;
  mesh.attributes = {AttributeSet::kColour};
  mesh.positions.resize(7);
  mesh.vertex_attributes.resize(7);
  mesh.triangles.resize(311);
  clusterTriangles(mesh);
  EXPECT_EQ(meshBytes(mesh), meshBytes(7, 311, mesh.attributes));
}

TEST(MeshCache, evictsTheLeastRecentlyUsedFirst) {
  MeshCache cache(2 * kMeshBytes);
  const MeshKey a{NodeKey{8}, 0}, b{NodeKey{9}, 0}, c{NodeKey{10}, 0};
  cache.insert(a, meshOf(100));
  cache.use(std::vector{a}, {});
  cache.trim();
  cache.insert(b, meshOf(100));
  cache.use(std::vector{b}, {});
  cache.trim();
  cache.insert(c, meshOf(100));
  cache.use(std::vector{c}, {});
  cache.trim();
  EXPECT_FALSE(cache.contains(a));
  EXPECT_TRUE(cache.contains(b));
  EXPECT_TRUE(cache.contains(c));
  EXPECT_LE(cache.bytes(), cache.budgetBytes());
}

TEST(MeshCache, keepsUsedAndPinnedMeshesBeyondTheBudget) {
  MeshCache cache(0);
  cache.insert({kRootKey, 2}, meshOf(100));
  cache.pin({kRootKey, 2});
  cache.insert({kChild, 0}, meshOf(100));
  cache.insert({kChild, 1}, meshOf(100));
  cache.use(std::vector{MeshKey{kChild, 0}}, {});
  cache.trim();
  EXPECT_TRUE(cache.contains({kRootKey, 2}));
  EXPECT_TRUE(cache.contains({kChild, 0}));
  EXPECT_FALSE(cache.contains({kChild, 1}));
}

TEST(MeshCache, evictsAncestorsLast) {
  MeshCache cache(2 * kMeshBytes);
  cache.insert({kRootKey, 0}, meshOf(100));
  cache.insert({kChild, 0}, meshOf(100));
  cache.insert({kGrandchild, 0}, meshOf(100));
  cache.use({}, {});
  cache.trim();
  EXPECT_FALSE(cache.contains({kGrandchild, 0}));
  cache.insert({NodeKey{9}, 0}, meshOf(100));
  cache.use({}, std::vector{MeshKey{kRootKey, 0}, MeshKey{kChild, 0}});
  cache.trim();
  EXPECT_FALSE(cache.contains({NodeKey{9}, 0}));
}

}  // namespace
}  // namespace lode::core
