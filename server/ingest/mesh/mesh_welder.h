#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "server/ingest/mesh/node_mesh.h"
#include "server/ingest/mesh/number_table.h"
#include "server/ingest/mesh/wedge_finder.h"

namespace lode::ingest {

/// Welds meshes vertex by vertex: merges equal positions, and merges wedges with equal attributes at the same
/// position. Numbers positions and wedges in order of addition. Use one welder for many leaves, to reuse its
/// memory. Not thread safe.
class MeshWelder {
 public:
  /// @param expected_positions  number of positions for which memory is reserved; the mesh may have more.
  void begin(AttributeSet attributes, size_t expected_positions, size_t expected_triangles);

  /// Finds the wedge of a triangle's corner, and adds it if it is new. @return the wedge's number.
  uint32_t addCorner(PositionCode position, uint8_t lca_depth, const VertexAttributes& attributes);
  uint32_t positionOf(uint32_t wedge) const noexcept { return mesh_.wedge_position[wedge]; }
  /// Adds a triangle, unless two of its corners are at one position.
  void addTriangle(glm::u32vec3 wedges);

  NodeMesh finish() { return std::move(mesh_); }

 private:
  NodeMesh mesh_;
  NumberTable table_;
  WedgeFinder wedges_;
};

/// Welds the meshes of several nodes into one. If a position has several lca_depths, it gets the smallest.
/// @param remap  receives one list per mesh, with the number in the result of each position. @pre every
/// position has a wedge.
NodeMesh mergeMeshes(std::span<const NodeMesh> meshes, std::vector<std::vector<uint32_t>>& remap);

/// Merges equal wedges of each position.
void joinEqualWedges(NodeMesh& mesh);

/// Converts a mesh to the form that payloads store: one vertex per wedge.
Mesh toMesh(const NodeMesh& mesh);

}  // namespace lode::ingest
