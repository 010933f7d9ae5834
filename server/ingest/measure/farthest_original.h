#pragma once

#include <span>

#include "server/ingest/measure/rung_input.h"
#include "server/ingest/measure/surface_walk.h"
#include "server/ingest/mesh/simplified_mesh.h"

namespace lode::ingest {

/// The largest distance of the model's own triangles, as far as a rung was made of these, from the rung, in
/// lattice steps, to 2 %: of all points of those that may hide the largest, as their corners and the ridges
/// of the rung that they cross say. (What is passed over, RungCheck looks at.)
/// @param walk   over the rung's mesh, which has triangles.
/// @param places of the input's positions on it; see placesOn().
/// @param known  a distance of some point of them. @return not below it.
float farthestOriginal(const SimplifiedMesh& rung, const RungInput& input, const SurfaceWalk& walk,
                       std::span<const SurfaceWalk::Place> places, float known);

}  // namespace lode::ingest
