#pragma once

#include "server/ingest/measure/lod_input.h"
#include "server/ingest/mesh/node_mesh.h"

namespace lode::ingest {

/// Returns an upper bound on the distance from a simplified mesh's boundary edges to the original boundary,
/// in lattice steps. The bound is the sum of two distances: from the edges to the input's references (see
/// ReferenceBoundary), and from these references to the original boundary (referenceGapSteps()). The first
/// distance is too large by at most 2 % or a quarter of a step. Compares each boundary edge with the
/// references that map to one of its ends. If these are farther away than the largest distance so far, also
/// compares the edge with neighbouring references.
float boundaryGap(const SimplifiedMesh& simplified, const LodInput& input);

}  // namespace lode::ingest
