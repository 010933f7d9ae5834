#pragma once

#include <cstdint>
#include <vector>

#include "common/mesh.h"

namespace lode::ingest {

constexpr uint8_t kNeverLocked = 255;

/// Mesh of a node during a build: topology by position, attributes by wedge.
struct NodeMesh {
  AttributeSet attributes;
  std::vector<PositionCode> positions;  ///< distinct
  std::vector<uint8_t> lca_depth;  ///< by position: depth of the lowest common ancestor of the leaves that
                                   ///< share it, or kNeverLocked; locked in nodes deeper than that
  std::vector<uint32_t> wedge_position;            ///< position of each wedge
  std::vector<VertexAttributes> wedge_attributes;  ///< by wedge; empty if the model has no attributes;
                                                   ///< (position, attributes) pairs are distinct
  std::vector<glm::u32vec3> triangles;             ///< wedges; their three positions are distinct
};

constexpr uint32_t kVanished = ~0u;

/// Result of simplification.
struct SimplifiedMesh {
  NodeMesh mesh;
  std::vector<uint32_t> remap;  ///< by position of the input: a position of the mesh, or kVanished if it has
                                ///< lost its last triangle
  bool is_clustered = false;    ///< made by clustering, which may connect separate parts
};

/// For each position of a simplified mesh, the nearest input position that maps to it.
std::vector<uint32_t> sourcesOf(const SimplifiedMesh& simplified, const NodeMesh& input);

}  // namespace lode::ingest
