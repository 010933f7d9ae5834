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

}  // namespace lode::ingest
