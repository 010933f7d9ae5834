#include "server/ingest/nodes/computed_normals.h"

#include <array>

#include <gtest/gtest.h>

#include "common/codec/octahedral.h"
#include "server/ingest/measure/surface_samples.h"
#include "server/ingest/simplify/collapse.h"
#include "tests/support/node_meshes.h"

namespace lode::ingest {
namespace {

constexpr uint8_t kComputed = AttributeSet::kNormal | AttributeSet::kComputedNormal;

void giveNormals(SimplifiedMesh& lod, const NodeMesh& mesh) {
  giveComputedNormals(lod, mesh, sourcesOf(lod, mesh), placesOn(lod, mesh, SurfaceWalk(lod.mesh)),
                      CreaseAngle(50));
}

/// A square with corner normals x, y, z and z. The first two corners merge into a corner of a triangle.
uint16_t normalAt(PositionCode place, uint8_t lca_depth) {
  NodeMesh mesh;
  mesh.attributes.bits = kComputed;
  mesh.positions = {packPosition({0, 0, 0}), packPosition({30, 0, 0}), packPosition({30, 30, 0}),
                    packPosition({0, 30, 0})};
  mesh.lca_depth.assign(4, lca_depth);
  mesh.wedge_position = {0, 1, 2, 3};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  for (const glm::vec3 axis :
       {glm::vec3(1, 0, 0), glm::vec3(0, 1, 0), glm::vec3(0, 0, 1), glm::vec3(0, 0, 1)})
    mesh.wedge_attributes.push_back({.normal = encodeOctahedral(axis), .material = 0});
  SimplifiedMesh lod;
  lod.mesh.positions = {place, mesh.positions[2], mesh.positions[3]};
  lod.mesh.lca_depth.assign(3, lca_depth);
  lod.mesh.wedge_position = {0, 1, 2};
  lod.mesh.triangles = {{0, 1, 2}};
  lod.remap = {0, 0, 1, 2};
  giveNormals(lod, mesh);
  return lod.mesh.wedge_attributes[0].normal;
}

TEST(ComputedNormals, approximateTheMeanNormalOfMergedPositions) {
  const glm::vec3 normal = decodeOctahedral(normalAt(packPosition({15, 0, 0}), kNeverLocked));
  EXPECT_NEAR(normal.x, normal.y, 0.02);
  EXPECT_GT(glm::dot(normal, glm::normalize(glm::vec3(1, 1, 0))), 0.9f);
}

TEST(ComputedNormals, stayExactAtUnmovedPositionsSharedByLeaves) {
  EXPECT_EQ(normalAt(packPosition({30, 0, 0}), 2), encodeOctahedral({0, 1, 0}));
}

/// Sum over the input's positions of the squared differences between their normals and the LOD's interpolated
/// ones.
float missed(const SimplifiedMesh& lod, const NodeMesh& mesh) {
  const std::vector<SurfaceWalk::Place> places = placesOn(lod, mesh, SurfaceWalk(lod.mesh));
  float sum = 0;
  for (size_t wedge = 0; wedge < mesh.wedge_position.size(); ++wedge) {
    const SurfaceWalk::Place& place = places[mesh.wedge_position[wedge]];
    glm::vec3 off = decodeOctahedral(mesh.wedge_attributes[wedge].normal);
    for (int k = 0; k < 3; ++k)
      off -= place.shares[k] *
             decodeOctahedral(lod.mesh.wedge_attributes[lod.mesh.triangles[place.triangle][k]].normal);
    sum += glm::dot(off, off);
  }
  return sum;
}

TEST(ComputedNormals, areSharperThanTheMeansOfMergedNormals) {
  NodeMesh mesh = test::nodeOf(test::makeSphere(60, 40, {.attributes = {AttributeSet::kNormal}}));
  mesh.attributes.bits = kComputed;
  for (size_t wedge = 0; wedge < mesh.wedge_position.size(); ++wedge) {
    VertexAttributes& attributes = mesh.wedge_attributes[wedge];
    const glm::vec3 outward = decodeOctahedral(attributes.normal);
    attributes.normal = encodeOctahedral(outward + 0.5f * glm::sin(8.f * outward));
  }
  collapse(withoutSmoothNormals(mesh), std::array<size_t, 1>{800}, {}, [&](size_t, SimplifiedMesh&& lod) {
    giveNormals(lod, mesh);
    SimplifiedMesh with_means = lod;
    std::vector<glm::vec3> sums(lod.mesh.positions.size(), glm::vec3(0));
    for (size_t wedge = 0; wedge < mesh.wedge_position.size(); ++wedge)
      sums[lod.remap[mesh.wedge_position[wedge]]] += decodeOctahedral(mesh.wedge_attributes[wedge].normal);
    for (size_t wedge = 0; wedge < lod.mesh.wedge_position.size(); ++wedge)
      with_means.mesh.wedge_attributes[wedge].normal = encodeOctahedral(sums[lod.mesh.wedge_position[wedge]]);
    EXPECT_LT(missed(lod, mesh), 0.95f * missed(with_means, mesh));
  });
}

/// Two squares at a fold with their own wedges along it, as an LOD in which nothing moved.
size_t wedgesOfAFold(uint32_t height, uint8_t lca_depth) {
  NodeMesh mesh;
  mesh.attributes.bits = kComputed;
  for (const glm::uvec3 p :
       {glm::uvec3(0, 0, 0), {0, 90, 0}, {90, 0, height}, {90, 90, height}, {180, 0, 0}, {180, 90, 0}})
    mesh.positions.push_back(packPosition(p));
  mesh.lca_depth.assign(6, lca_depth);
  mesh.wedge_position = {0, 1, 2, 3, 2, 3, 4, 5};
  for (const float x : {-1.f, 1.f})
    mesh.wedge_attributes.insert(mesh.wedge_attributes.end(), 4,
                                 {.normal = encodeOctahedral({x, 0, 1}), .material = 0});
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 6, 7}, {4, 7, 5}};
  SimplifiedMesh lod{mesh, {0, 1, 2, 3, 4, 5}};
  giveNormals(lod, mesh);
  return lod.mesh.wedge_position.size();
}

TEST(ComputedNormals, mergeWhereACreaseVanishesUnlessLeavesShareIt) {
  EXPECT_EQ(wedgesOfAFold(90, kNeverLocked), 8u) << "90 degrees";
  EXPECT_EQ(wedgesOfAFold(20, kNeverLocked), 6u) << "25 degrees";
  EXPECT_EQ(wedgesOfAFold(20, 2), 8u);
}

TEST(ComputedNormals, areGivenToEveryVertexOfALod) {
  NodeMesh mesh = test::nodeOf(test::makeSphere(30, 20, {.attributes = {AttributeSet::kNormal}}));
  mesh.attributes.bits = kComputed;
  collapse(withoutSmoothNormals(mesh), std::array<size_t, 1>{200}, {}, [&](size_t, SimplifiedMesh&& lod) {
    EXPECT_TRUE(lod.mesh.wedge_attributes.empty());
    giveNormals(lod, mesh);
    EXPECT_EQ(lod.mesh.attributes.bits, kComputed);
    EXPECT_EQ(lod.mesh.wedge_attributes.size(), lod.mesh.positions.size());
  });
}

TEST(ComputedNormals, leaveOtherAttributesAsTheyAre) {
  constexpr uint8_t kColoured = kComputed | AttributeSet::kColour;
  NodeMesh mesh = test::nodeOf(test::makeSphere(30, 20, {.attributes = {AttributeSet::kColour}}));
  for (VertexAttributes& attributes : mesh.wedge_attributes) attributes.normal = 77;
  mesh.attributes.bits = kColoured;
  const NodeMesh bare = withoutSmoothNormals(mesh);
  EXPECT_EQ(bare.attributes.bits, AttributeSet::kColour);
  ASSERT_EQ(bare.wedge_attributes.size(), mesh.wedge_attributes.size());
  for (size_t i = 0; i < bare.wedge_attributes.size(); ++i) {
    EXPECT_EQ(bare.wedge_attributes[i].normal, 0);
    EXPECT_EQ(bare.wedge_attributes[i].colour, mesh.wedge_attributes[i].colour);
  }
  collapse(bare, std::array<size_t, 1>{200}, {}, [&](size_t, SimplifiedMesh&& lod) {
    const std::vector<VertexAttributes> before = lod.mesh.wedge_attributes;
    giveNormals(lod, mesh);
    EXPECT_EQ(lod.mesh.attributes.bits, kColoured);
    ASSERT_EQ(lod.mesh.wedge_attributes.size(), before.size());
    for (size_t i = 0; i < before.size(); ++i)
      EXPECT_EQ(lod.mesh.wedge_attributes[i].colour, before[i].colour);
  });
}

}  // namespace
}  // namespace lode::ingest
