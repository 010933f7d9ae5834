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
  AttributeSet soup_attributes;  ///< the file's
  UvGrid uv_grid;
  uint64_t dropped_triangles = 0;
  DereferenceCounts counts;  ///< by dereference

  /// The file's, with computed normals where it has none.
  AttributeSet payloadAttributes() const noexcept {
    AttributeSet attributes = soup_attributes;
    if (!attributes.has(AttributeSet::kNormal))
      attributes.bits |= AttributeSet::kNormal | AttributeSet::kComputedNormal;
    return attributes;
  }
};

}  // namespace lode::ingest
