#pragma once

#include <cstdint>
#include <vector>

#include "server/ingest/node_mesh.h"

namespace lode::ingest {

constexpr uint32_t kVanished = ~0u;

/// What a simplifier has made of a mesh.
struct SimplifiedMesh {
  NodeMesh mesh;
  std::vector<uint32_t> became;  ///< of each position of the input: one of the mesh, or kVanished where its
                                 ///< last triangle has gone
};

}  // namespace lode::ingest
