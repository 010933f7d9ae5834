#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <random>
#include <set>
#include <unordered_map>
#include <utility>
#include <vector>

#include "common/mesh.h"
#include "server/ingest/mesh/node_mesh.h"
#include "server/ingest/simplify/collapse_mesh.h"
#include "tests/support/test_meshes.h"

/// Nodes of a build, made from meshes or from a seed, and helpers that examine them.
namespace lode::test {

/// Converts a mesh to a node's mesh with welded positions. No vertex is locked.
inline ingest::NodeMesh nodeOf(const Mesh& mesh) {
  ingest::NodeMesh node;
  node.attributes = mesh.attributes;
  std::unordered_map<uint64_t, uint32_t> known;
  for (const PositionCode code : mesh.positions) {
    const auto [i, added] = known.emplace(code.value, static_cast<uint32_t>(node.positions.size()));
    if (added) node.positions.push_back(code);
    node.wedge_position.push_back(i->second);
  }
  node.lca_depth.assign(node.positions.size(), ingest::kNeverLocked);
  node.wedge_attributes = mesh.vertex_attributes;
  node.triangles = mesh.triangles;
  if (node.wedge_attributes.empty()) {  // without attributes, each position is one wedge
    for (glm::u32vec3& t : node.triangles)
      t = {node.wedge_position[t.x], node.wedge_position[t.y], node.wedge_position[t.z]};
    node.wedge_position.resize(node.positions.size());
    for (uint32_t i = 0; i < node.wedge_position.size(); ++i) node.wedge_position[i] = i;
  }
  return node;
}

/// Makes triangles between random positions, with edges of any number of triangles, and opposite and
/// identical triangles.
inline ingest::NodeMesh makeTangle(uint32_t positions, uint32_t triangles, uint32_t seed) {
  std::mt19937 random(seed);
  ingest::NodeMesh node;
  std::set<uint64_t> used;
  while (node.positions.size() < positions) {
    const PositionCode code = packPosition({random() % 64, random() % 64, random() % 64});
    if (used.insert(code.value).second) node.positions.push_back(code);
  }
  node.lca_depth.assign(positions, ingest::kNeverLocked);
  for (uint32_t i = 0; i < positions; ++i) node.wedge_position.push_back(i);
  while (node.triangles.size() < triangles) {
    const glm::u32vec3 t(random() % positions, random() % positions, random() % positions);
    if (t.x != t.y && t.y != t.z && t.z != t.x) node.triangles.push_back(t);
  }
  return node;
}

inline std::vector<ingest::CollapseMesh::Edge> edgesOf(const ingest::CollapseMesh& mesh) {
  std::vector<ingest::CollapseMesh::Edge> edges;
  mesh.forEachEdge([&](const ingest::CollapseMesh::Edge& edge) { edges.push_back(edge); });
  return edges;
}

using PositionEdge = std::array<uint64_t, 2>;  ///< codes of both ends, lower code first

/// Returns the edges, by position, that an odd number of triangles use.
inline std::set<PositionEdge> oddEdges(const ingest::NodeMesh& node) {
  std::set<PositionEdge> odd;
  for (const glm::u32vec3 t : node.triangles) {
    for (int k = 0; k < 3; ++k) {
      const uint64_t a = node.positions[node.wedge_position[t[k]]].value;
      const uint64_t b = node.positions[node.wedge_position[t[(k + 1) % 3]]].value;
      const PositionEdge edge{std::min(a, b), std::max(a, b)};
      if (!odd.erase(edge)) odd.insert(edge);
    }
  }
  return odd;
}

/// Returns the points of a fine barycentric grid over every triangle.
inline std::vector<glm::dvec3> pointsOver(const ingest::NodeMesh& mesh, int steps) {
  std::vector<glm::dvec3> points;
  for (const glm::u32vec3& t : mesh.triangles) {
    const glm::dvec3 a(unpackPosition(mesh.positions[mesh.wedge_position[t.x]]));
    const glm::dvec3 b(unpackPosition(mesh.positions[mesh.wedge_position[t.y]]));
    const glm::dvec3 c(unpackPosition(mesh.positions[mesh.wedge_position[t.z]]));
    for (int i = 0; i <= steps; ++i) {
      for (int j = 0; i + j <= steps; ++j)
        points.push_back(a + (b - a) * (double(i) / steps) + (c - a) * (double(j) / steps));
    }
  }
  return points;
}

}  // namespace lode::test
