#pragma once

#include <cstdint>
#include <span>

#include "server/ingest/measure/lod_input.h"
#include "server/ingest/mesh/node_mesh.h"

namespace lode::ingest {

/// The largest distance of an LOD from the mesh that it was made of, lattice steps: of its vertices, of a few
/// points of each triangle, and where these come near the largest, of many.
/// @param places  of the input's positions on the LOD; see placesOn(). @param sources  see sourcesOf().
/// @param known  what is nearer does not matter. @return not below it.
float farthestOfLod(const SimplifiedMesh& lod, const LodInput& input,
                    std::span<const SurfaceWalk::Place> places, std::span<const uint32_t> sources,
                    float known);

/// The largest distance of an LOD's edges from the mesh that it was made of, lattice steps, to 2 %: of all
/// their points. (An edge that clustering has made may lead across a notch of the mesh's boundary, or from
/// sheet to sheet, and be near it wherever farthestOfLod() looks.)
/// @param sources  see sourcesOf(). @param known  what is nearer does not matter. @return not below it.
float farthestAlongEdges(const SimplifiedMesh& lod, const LodInput& input, std::span<const uint32_t> sources,
                         float known);

}  // namespace lode::ingest
