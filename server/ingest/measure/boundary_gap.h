#pragma once

#include "server/ingest/measure/lod_input.h"
#include "server/ingest/mesh/node_mesh.h"

namespace lode::ingest {

/// Returns an upper bound on the distance from a simplified mesh's boundary edges to the original boundary,
/// in lattice steps. The bound is the sum of two parts: the gap of the input's references, and the distance
/// from the edges to these references. The second part is too large by at most 2 % or a quarter of a step.
/// Each boundary edge is the image of boundary edges of the input. The function compares the edge with the
/// references that map to it or to its neighbours. If these references are far from the edge, the function
/// also compares the references next to them.
float boundaryGap(const SimplifiedMesh& simplified, const LodInput& input);

}  // namespace lode::ingest
