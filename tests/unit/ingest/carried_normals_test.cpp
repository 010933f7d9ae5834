#include "server/ingest/carried_normals.h"

#include <gtest/gtest.h>

#include "common/octahedral.h"
#include "tests/support/node_meshes.h"

namespace lode::ingest {
namespace {

/// Four positions in a row with normals of their own, of which all but the first become one.
struct Row {
  NodeMesh mesh;
  SimplifiedMesh rung;

  Row() {
    mesh.attributes.bits = AttributeSet::kNormal | AttributeSet::kComputedNormal;
    const glm::vec3 normals[4] = {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
    for (uint32_t i = 0; i < 4; ++i) {
      mesh.positions.push_back(packPosition({i, 0, 0}));
      mesh.lca_depth.push_back(kNeverLocked);
      mesh.wedge_position.push_back(i);
      mesh.wedge_attributes.push_back({.normal = encodeOctahedral(normals[i])});
    }
    rung.mesh.positions = {mesh.positions[0], mesh.positions[1]};
    rung.mesh.lca_depth = {kNeverLocked, kNeverLocked};
    rung.mesh.wedge_position = {0, 1};
    rung.became = {0, 1, 1, 1};
  }
  uint16_t normalAfter(uint32_t position) {
    const CarriedNormals normals(mesh, 2);
    normals.giveTo(rung);
    return rung.mesh.wedge_attributes[position].normal;
  }
};

TEST(CarriedNormals, leaveTheMeshWithoutAttributes) {
  Row row;
  const CarriedNormals normals(row.mesh, 2);
  EXPECT_EQ(row.mesh.attributes.bits, 0);
  EXPECT_TRUE(row.mesh.wedge_attributes.empty());
}

TEST(CarriedNormals, areTheMeanWherePositionsHaveBecomeOne) {
  EXPECT_EQ(Row().normalAfter(1), encodeOctahedral({1, 1, 0}));
}

TEST(CarriedNormals, stayToTheBitWhereNothingWasJoined) {
  Row row;
  const uint16_t code = row.mesh.wedge_attributes[0].normal;
  EXPECT_EQ(row.normalAfter(0), code);
}

TEST(CarriedNormals, stayToTheBitAtALockedPosition) {
  for (const size_t locked : {1u, 2u, 3u}) {
    Row row;
    row.mesh.lca_depth[locked] = 1;
    const uint16_t code = row.mesh.wedge_attributes[locked].normal;
    EXPECT_EQ(row.normalAfter(1), code) << locked;
  }
}

TEST(CarriedNormals, keepOneOfTheirsWhereTheMeanVanishes) {
  Row row;
  row.mesh.wedge_attributes[2].normal = encodeOctahedral({-1, 0, 0});
  row.rung.became = {0, 1, 1, kVanished};
  const uint16_t normal = row.normalAfter(1);
  EXPECT_TRUE(normal == encodeOctahedral({1, 0, 0}) || normal == encodeOctahedral({-1, 0, 0}));
}

}  // namespace
}  // namespace lode::ingest
