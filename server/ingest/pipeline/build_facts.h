#pragma once

#include <cstdint>

#include "common/mesh.h"
#include "server/ingest/soup/dereference.h"
#include "server/ingest/soup/lattice_choice.h"
#include "server/ingest/soup/uv_grid.h"

namespace lode::ingest {

/// What stages find out about the model and later ones need to know; each of the journal's stages notes it.
struct BuildFacts {
  LatticeChoice choice;          ///< by the scan, as the next three are
  AttributeSet soup_attributes;  ///< those that are taken of the file: no normals where none has a length
  UvGrid uv_grid;
  uint64_t dropped_triangles = 0;
  DereferenceCounts counts;  ///< by dereference

  /// The same, with computed normals where they have none.
  AttributeSet payloadAttributes() const noexcept {
    AttributeSet attributes = soup_attributes;
    if (!attributes.has(AttributeSet::kNormal))
      attributes.bits |= AttributeSet::kNormal | AttributeSet::kComputedNormal;
    return attributes;
  }
};

}  // namespace lode::ingest
