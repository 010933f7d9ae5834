#pragma once

#include "server/ingest/measure/lod_input.h"
#include "server/ingest/mesh/node_mesh.h"

namespace lode::ingest {

/// Upper bound on the distance from a simplified mesh's boundary edges to the original boundary, in lattice
/// steps: the gap of the input's references plus the distance to these references, overestimated by at most 2
/// % or a quarter of a step. Each boundary edge is the image of the input's boundary edges. It is compared
/// with the references that map to it or share an end with it; if they are far, also with the references next
/// to those.
float boundaryGap(const SimplifiedMesh& simplified, const LodInput& input);

}  // namespace lode::ingest
