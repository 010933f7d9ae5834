#pragma once

#include <cstddef>
#include <cstdint>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "server/ingest/simplify/collapse.h"
#include "tests/support/node_meshes.h"

/// Shared by the tests of both simplifiers.
namespace lode::ingest {

using test::MeshOptions;

inline MeshOptions with(uint8_t bits, uint32_t seed = 1) {
  MeshOptions options;
  options.attributes.bits = bits;
  options.seed = seed;
  return options;
}

struct Snapshot {
  size_t target;
  NodeMesh mesh;
};

/// Locks one in `one_in` positions, selected by hash.
inline void lockSome(NodeMesh& mesh, uint32_t seed, uint32_t one_in) {
  std::mt19937 random(seed);
  for (uint8_t& depth : mesh.lca_depth)
    if (random() % one_in == 0) depth = 1;
}

/// Locks the ends of all odd edges, like the border of a node.
inline void lockOddEdges(NodeMesh& mesh) {
  std::set<uint64_t> codes;
  for (const test::PositionEdge& edge : test::oddEdges(mesh)) codes.insert(edge.begin(), edge.end());
  for (size_t i = 0; i < mesh.positions.size(); ++i)
    if (codes.contains(mesh.positions[i].value)) mesh.lca_depth[i] = 1;
}

/// Checks invariants of every node mesh.
inline void expectSound(const NodeMesh& mesh) {
  EXPECT_EQ(std::set(mesh.positions.begin(), mesh.positions.end()).size(), mesh.positions.size());
  ASSERT_EQ(mesh.lca_depth.size(), mesh.positions.size());
  std::set<uint32_t> used;
  for (const glm::u32vec3 t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      ASSERT_LT(t[k], mesh.wedge_position.size());
      used.insert(t[k]);
    }
    const uint32_t a = mesh.wedge_position[t.x], b = mesh.wedge_position[t.y], c = mesh.wedge_position[t.z];
    EXPECT_TRUE(a != b && b != c && c != a);
  }
  EXPECT_EQ(used.size(), mesh.wedge_position.size()) << "a wedge without a triangle";
  if (mesh.wedge_attributes.empty()) return;
  ASSERT_EQ(mesh.wedge_attributes.size(), mesh.wedge_position.size());
  for (uint32_t i = 0; i < mesh.wedge_position.size(); ++i) {
    for (uint32_t j = i + 1;
         j < mesh.wedge_position.size() && mesh.wedge_position[j] == mesh.wedge_position[i]; ++j)
      EXPECT_FALSE(mesh.wedge_attributes[i] == mesh.wedge_attributes[j]) << "two equal wedges at a position";
  }
}

}  // namespace lode::ingest
