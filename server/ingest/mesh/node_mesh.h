#pragma once

#include <cstdint>
#include <vector>

#include "common/mesh.h"

namespace lode::ingest {

constexpr uint8_t kNeverLocked = 255;

/// Mesh of a node during a build: topology by position, attributes by wedge.
struct NodeMesh {
  AttributeSet attributes;
  std::vector<PositionCode> positions;  ///< distinct positions of the mesh
  /// For each position, the depth of the lowest common ancestor of the leaves that share it, or kNeverLocked;
  /// nodes below that depth lock the position.
  std::vector<uint8_t> lca_depth;
  std::vector<uint32_t> wedge_position;  ///< position of each wedge
  /// Attributes of each wedge; empty if the model has no attributes; wedges of one position have different
  /// attributes.
  std::vector<VertexAttributes> wedge_attributes;
  /// Wedges of each triangle's corners; the corners have three distinct positions.
  std::vector<glm::u32vec3> triangles;
};

constexpr uint32_t kVanished = ~0u;

/// Result of simplification.
struct SimplifiedMesh {
  NodeMesh mesh;
  std::vector<uint32_t> remap;  ///< for each position of the input, the position of the mesh that it maps to,
                                ///< or kVanished if that position has lost its last triangle
  bool is_clustered = false;    ///< the mesh results from clustering, which may connect separate parts
};

/// Returns for each position of a simplified mesh the nearest input position that maps to it.
std::vector<uint32_t> sourcesOf(const SimplifiedMesh& simplified, const NodeMesh& input);

}  // namespace lode::ingest
