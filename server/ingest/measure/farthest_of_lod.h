#pragma once

#include <cstdint>
#include <span>

#include "server/ingest/measure/lod_input.h"
#include "server/ingest/mesh/node_mesh.h"

namespace lode::ingest {

/// Returns the largest distance of an LOD from its input, in lattice steps. Measures at the LOD's vertices,
/// at a few points of each triangle, and at many points of triangles whose distance is near the maximum.
/// @param places  for each position of the input, its place on the LOD; see placesOn(). @param sources  see
/// sourcesOf().
/// @param lower_bound  smaller distances do not matter. @return at least lower_bound.
float farthestOfLod(const SimplifiedMesh& lod, const LodInput& input,
                    std::span<const SurfaceWalk::Place> places, std::span<const uint32_t> sources,
                    float lower_bound);

/// Returns the largest distance of any point of an LOD's edges from the LOD's input, to 2 %, in lattice
/// steps. Clustering may create edges across a notch of the boundary or between sheets. Call this function
/// for a clustered LOD, because farthestOfLod() may sample such an edge only where it is close to the input.
/// @param sources  see sourcesOf(). @param lower_bound  smaller distances do not matter. @return at least
/// lower_bound.
float farthestAlongEdges(const SimplifiedMesh& lod, const LodInput& input, std::span<const uint32_t> sources,
                         float lower_bound);

}  // namespace lode::ingest
