#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "server/ingest/mesh/node_mesh.h"
#include "server/ingest/mesh/number_table.h"

namespace lode::ingest {

/// Puts meshes together vertex by vertex: equal positions become one, and of a position's wedges, equal
/// attributes. Numbers follow the order of addition. Reused between leaves. For one thread.
class MeshWelder {
 public:
  /// @param expected_positions  how many to make room for; there may be more.
  void begin(AttributeSet attributes, size_t expected_positions, size_t expected_triangles);

  /// @return the wedge's number.
  uint32_t addCorner(PositionCode position, uint8_t lca_depth, const VertexAttributes& attributes);
  uint32_t positionOf(uint32_t wedge) const noexcept { return mesh_.wedge_position[wedge]; }
  /// Left out if two of its corners have one position.
  void addTriangle(glm::u32vec3 wedges);

  NodeMesh finish() { return std::move(mesh_); }

 private:
  NodeMesh mesh_;
  NumberTable table_;
  std::vector<uint32_t> first_wedge_;  ///< of each position
  std::vector<uint32_t> next_wedge_;   ///< of each wedge: another of its position, or NumberTable::kAbsent
};

/// The union of nodes' meshes, welded. Where meshes disagree on a position's lock, the stronger one stays.
/// @param became  gets for each mesh the numbers that its positions have in the union; all of them have
/// wedges.
NodeMesh mergeMeshes(std::span<const NodeMesh> meshes, std::vector<std::vector<uint32_t>>& became);

/// Makes wedges of one position that have become equal one.
void joinEqualWedges(NodeMesh& mesh);

/// The mesh as payloads hold it: one vertex a wedge.
Mesh toMesh(const NodeMesh& mesh);

}  // namespace lode::ingest
