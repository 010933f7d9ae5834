#pragma once

#include <cstdint>
#include <vector>

#include "server/ingest/mesh/node_mesh.h"

namespace lode::ingest {

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
