#pragma once

#include <cstdint>
#include <span>

#include "server/ingest/measure/lod_input.h"
#include "server/ingest/mesh/node_mesh.h"

namespace lode::ingest {

/// Returns the largest distance from a point of an LOD to the LOD's input, in lattice steps. Measures at the
/// LOD's vertices, at a few points of each triangle, and at many points of triangles whose distance is near
/// the maximum.
/// @param places  for each position of the input, its place on the LOD; see placesOn(). @param sources  see
/// sourcesOf().
/// @param lower_bound  smaller distances do not matter. @return at least lower_bound.
float farthestOfLod(const SimplifiedMesh& lod, const LodInput& input,
                    std::span<const SurfaceWalk::Place> places, std::span<const uint32_t> sources,
                    float lower_bound);

/// Returns the largest distance from a point on an edge of an LOD to the LOD's input, to 2 %, in lattice
/// steps. Call this function for a clustered LOD: clustering may create edges across a notch of the boundary
/// or between two sheets, and farthestOfLod() may sample such an edge only where it is near the input.
/// @param sources  see sourcesOf(). @param lower_bound  smaller distances do not matter. @return at least
/// lower_bound.
float farthestAlongEdges(const SimplifiedMesh& lod, const LodInput& input, std::span<const uint32_t> sources,
                         float lower_bound);

}  // namespace lode::ingest
