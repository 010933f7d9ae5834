#include "server/ingest/computed_normals.h"

#include <array>

#include <gtest/gtest.h>

#include "common/octahedral.h"
#include "server/ingest/collapse.h"
#include "tests/support/node_meshes.h"

namespace lode::ingest {
namespace {

constexpr uint8_t kComputed = AttributeSet::kNormal | AttributeSet::kComputedNormal;

/// One triangle whose corners look along the axes, and a rung whose only position lies somewhere on it.
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
  rung.became = {0, 0, 0};
  giveComputedNormals(rung, mesh, SurfaceWalk(mesh), sourcesOf(rung, mesh));
  return rung.mesh.wedge_attributes[0].normal;
}

TEST(ComputedNormals, areMixedFromTheTriangleThatAPositionLiesOn) {
  EXPECT_EQ(normalAt(packPosition({10, 10, 0})), encodeOctahedral({1, 1, 1}));
  EXPECT_EQ(normalAt(packPosition({15, 15, 0})), encodeOctahedral({0, 1, 1}));
}

TEST(ComputedNormals, stayToTheBitWhereAPositionHasNotMoved) {
  EXPECT_EQ(normalAt(packPosition({30, 0, 0})), encodeOctahedral({0, 1, 0}));
}

TEST(ComputedNormals, areGivenToEveryVertexOfARung) {
  NodeMesh mesh = test::nodeOf(test::makeSphere(30, 20, {.attributes = {AttributeSet::kNormal}}));
  mesh.attributes.bits = kComputed;
  ASSERT_TRUE(hasComputedNormalsAlone(mesh));
  collapse(withoutAttributes(mesh), std::array<size_t, 1>{200}, {}, [&](size_t, SimplifiedMesh&& rung) {
    EXPECT_TRUE(rung.mesh.wedge_attributes.empty());
    giveComputedNormals(rung, mesh, SurfaceWalk(mesh), sourcesOf(rung, mesh));
    EXPECT_EQ(rung.mesh.attributes.bits, kComputed);
    EXPECT_EQ(rung.mesh.wedge_attributes.size(), rung.mesh.positions.size());
  });
}

}  // namespace
}  // namespace lode::ingest
