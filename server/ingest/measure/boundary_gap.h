#pragma once

#include "server/ingest/measure/lod_input.h"
#include "server/ingest/mesh/node_mesh.h"

namespace lode::ingest {

/// Upper bound on the distance from a simplified mesh's boundary edges to the original boundary, in lattice
/// steps: the gap of the input's references plus the distance to these references, too large by at
/// most 2 % or a quarter of a step. Each boundary edge is the image of the input's boundary edges. The
/// function compares each boundary edge with the references that map to the edge or to a neighbour at one of
/// its ends; if they are far from the edge, also with the references next to them.
float boundaryGap(const SimplifiedMesh& simplified, const LodInput& input);

}  // namespace lode::ingest
