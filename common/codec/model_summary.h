#pragma once

#include <cstdint>
#include <string>

#include "common/codec/blob.h"
#include "common/lattice.h"
#include "common/mesh.h"

namespace lode {

/// Description of a model. The store's header contains it, and clients receive it before any blob of the
/// model.
struct ModelSummary {
  std::string name;  ///< file name of the store without .lode
  Digest build_id;   ///< hash of the index; any change of the store changes the hash
  Lattice lattice;
  LatticeBox box;  ///< box of all nodes
  AttributeSet attributes;
  uint64_t triangles = 0;         ///< triangles of the leaves
  uint64_t dropped = 0;           ///< input triangles that the build dropped (I1 of docs/architecture.md)
  uint64_t stored_triangles = 0;  ///< triangles of all LODs
  uint64_t nodes = 0;
  uint64_t payloads = 0;
  uint64_t bytes = 0;         ///< size of the store file
  uint32_t depth = 0;         ///< depth of the deepest node
  float max_error_model = 0;  ///< error of the root's coarsest LOD
  uint32_t triangles_per_node = 0;
  BlobRef root_page;
  /// The texture set (common/codec/texture_set.h); empty reference if the model has no textures.
  BlobRef textures;

  bool operator==(const ModelSummary&) const = default;
};

}  // namespace lode
