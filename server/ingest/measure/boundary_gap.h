#pragma once

#include "server/ingest/measure/lod_input.h"
#include "server/ingest/mesh/node_mesh.h"

namespace lode::ingest {

/// What no boundary of a simplified mesh is farther from a boundary of the original, in lattice steps: what
/// the references of its input are, and what it is from these, at most 2 % or a quarter of a step too much. A
/// boundary is the image of boundaries, and is compared with those references alone that have become it or
/// what meets its ends, and where these are far, with those that meet them.
float boundaryGap(const SimplifiedMesh& simplified, const LodInput& input);

}  // namespace lode::ingest
