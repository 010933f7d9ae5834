#pragma once

#include <cstdint>
#include <vector>

#include "common/mesh.h"

namespace lode::ingest {

constexpr uint8_t kNeverLocked = 255;

/// Mesh of a node during a build. A wedge is a position with one set of attributes; a position on a seam has
/// several wedges.
struct NodeMesh {
  AttributeSet attributes;
  std::vector<PositionCode> positions;  ///< distinct positions of the mesh
  /// For each position, the depth of the lowest common ancestor of all leaves that share it. Deeper nodes
  /// lock the position: their LODs must not move it. kNeverLocked if only one leaf has the position.
  std::vector<uint8_t> lca_depth;
  std::vector<uint32_t> wedge_position;  ///< position of each wedge
  /// Attributes of each wedge. Wedges of one position have different attributes. Empty if the model has no
  /// attributes.
  std::vector<VertexAttributes> wedge_attributes;
  /// Wedges of each triangle's corners; the corners have three distinct positions.
  std::vector<glm::u32vec3> triangles;
};

constexpr uint32_t kVanished = ~0u;

/// Result of simplification.
struct SimplifiedMesh {
  NodeMesh mesh;
  /// Maps each position of the input to a position of the mesh, or to kVanished if that position has lost its
  /// last triangle.
  std::vector<uint32_t> remap;
  /// True if the mesh was made by clustering, which may connect separate parts.
  bool is_clustered = false;
};

/// Returns for each position of a simplified mesh the nearest input position that maps to it.
std::vector<uint32_t> sourcesOf(const SimplifiedMesh& simplified, const NodeMesh& input);

}  // namespace lode::ingest
