#include "server/ingest/computed_normals.h"

#include <array>

#include <gtest/gtest.h>

#include "common/octahedral.h"
#include "server/ingest/collapse.h"
#include "tests/support/node_meshes.h"

namespace lode::ingest {
namespace {

constexpr uint8_t kComputed = AttributeSet::kNormal | AttributeSet::kComputedNormal;

/// One triangle whose corners look along the axes, of which the first two become a rung's only position.
uint16_t normalAt(PositionCode place) {
  NodeMesh mesh;
  mesh.attributes.bits = kComputed;
  mesh.positions = {packPosition({0, 0, 0}), packPosition({30, 0, 0}), packPosition({0, 30, 0})};
  mesh.lca_depth.assign(3, kNeverLocked);
  mesh.wedge_position = {0, 1, 2};
  mesh.triangles = {{0, 1, 2}};
  for (const glm::vec3 axis : {glm::vec3(1, 0, 0), glm::vec3(0, 1, 0), glm::vec3(0, 0, 1)})
    mesh.wedge_attributes.push_back({.normal = encodeOctahedral(axis), .material = 0});
  SimplifiedMesh rung;
  rung.mesh.positions = {place};
  rung.mesh.wedge_position = {0};
  rung.became = {0, 0, kVanished};
  giveComputedNormals(rung, mesh, sourcesOf(rung, mesh));
  return rung.mesh.wedge_attributes[0].normal;
}

TEST(ComputedNormals, areTheMeanOfThoseThatHaveBecomeAPosition) {
  EXPECT_EQ(normalAt(packPosition({10, 10, 0})), encodeOctahedral({1, 1, 0}));
}

TEST(ComputedNormals, stayToTheBitWhereAPositionHasNotMoved) {
  EXPECT_EQ(normalAt(packPosition({30, 0, 0})), encodeOctahedral({0, 1, 0}));
}

TEST(ComputedNormals, areGivenToEveryVertexOfARung) {
  NodeMesh mesh = test::nodeOf(test::makeSphere(30, 20, {.attributes = {AttributeSet::kNormal}}));
  mesh.attributes.bits = kComputed;
  collapse(withoutComputedNormals(mesh), std::array<size_t, 1>{200}, {}, [&](size_t, SimplifiedMesh&& rung) {
    EXPECT_TRUE(rung.mesh.wedge_attributes.empty());
    giveComputedNormals(rung, mesh, sourcesOf(rung, mesh));
    EXPECT_EQ(rung.mesh.attributes.bits, kComputed);
    EXPECT_EQ(rung.mesh.wedge_attributes.size(), rung.mesh.positions.size());
  });
}

TEST(ComputedNormals, leaveOtherAttributesAsTheyAre) {
  constexpr uint8_t kColoured = kComputed | AttributeSet::kColour;
  NodeMesh mesh = test::nodeOf(test::makeSphere(30, 20, {.attributes = {AttributeSet::kColour}}));
  for (VertexAttributes& attributes : mesh.wedge_attributes) attributes.normal = 77;
  mesh.attributes.bits = kColoured;
  const NodeMesh bare = withoutComputedNormals(mesh);
  EXPECT_EQ(bare.attributes.bits, AttributeSet::kColour);
  ASSERT_EQ(bare.wedge_attributes.size(), mesh.wedge_attributes.size());
  for (size_t i = 0; i < bare.wedge_attributes.size(); ++i) {
    EXPECT_EQ(bare.wedge_attributes[i].normal, 0);
    EXPECT_EQ(bare.wedge_attributes[i].colour, mesh.wedge_attributes[i].colour);
  }
  collapse(bare, std::array<size_t, 1>{200}, {}, [&](size_t, SimplifiedMesh&& rung) {
    const std::vector<VertexAttributes> before = rung.mesh.wedge_attributes;
    giveComputedNormals(rung, mesh, sourcesOf(rung, mesh));
    EXPECT_EQ(rung.mesh.attributes.bits, kColoured);
    ASSERT_EQ(rung.mesh.wedge_attributes.size(), before.size());
    for (size_t i = 0; i < before.size(); ++i)
      EXPECT_EQ(rung.mesh.wedge_attributes[i].colour, before[i].colour);
  });
}

}  // namespace
}  // namespace lode::ingest
