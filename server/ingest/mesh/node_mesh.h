#pragma once

#include <cstdint>
#include <vector>

#include "common/mesh.h"

namespace lode::ingest {

constexpr uint8_t kNeverLocked = 255;

/// The mesh of a node while it is built: topology by position, attributes by wedge.
struct NodeMesh {
  AttributeSet attributes;
  std::vector<PositionCode> positions;  ///< distinct
  std::vector<uint8_t> lca_depth;       ///< one a position: depth of the lowest common ancestor of the leaves
                                        ///< that share it, or kNeverLocked; locked in nodes deeper than that
  std::vector<uint32_t> wedge_position;            ///< position of each wedge
  std::vector<VertexAttributes> wedge_attributes;  ///< one a wedge, or empty where the model has no
                                                   ///< attributes; (position, attributes) pairs are distinct
  std::vector<glm::u32vec3> triangles;             ///< wedges; their positions are distinct within a triangle
};

constexpr uint32_t kVanished = ~0u;

/// What a simplifier has made of a mesh.
struct SimplifiedMesh {
  NodeMesh mesh;
  std::vector<uint32_t> became;  ///< of each position of the input: one of the mesh, or kVanished where its
                                 ///< last triangle has gone
  bool is_clustered = false;     ///< by cells, without regard to where edges lead
};

/// Of each position of a simplified mesh, the nearest of those of the input that have become it.
std::vector<uint32_t> sourcesOf(const SimplifiedMesh& simplified, const NodeMesh& input);

}  // namespace lode::ingest
