#pragma once

#include <cstdint>
#include <string>

#include "common/codec/blob.h"
#include "common/lattice.h"
#include "common/mesh.h"

namespace lode {

/// What a client must know of a model before anything else; part of the store's header and of the answer to
/// Open.
struct ModelSummary {
  std::string name;  ///< the store file's stem
  Digest build_id;   ///< hash of the index: changes when anything in the store does
  Lattice lattice;
  LatticeBox box;  ///< of all nodes
  AttributeSet attributes;
  uint64_t triangles = 0;         ///< in the leaves
  uint64_t dropped = 0;           ///< of the input, for the reasons of design I1
  uint64_t stored_triangles = 0;  ///< in all LODs
  uint64_t nodes = 0;
  uint64_t payloads = 0;
  uint64_t bytes = 0;         ///< of the store file
  uint32_t depth = 0;         ///< of the deepest node
  float max_error_model = 0;  ///< of the root's coarsest LOD
  uint32_t triangles_per_node = 0;
  BlobRef root_page;
  BlobRef textures;  ///< the texture set (common/codec/texture_set.h), or no blob

  bool operator==(const ModelSummary&) const = default;
};

}  // namespace lode
