#pragma once

#include <cstdint>
#include <span>

#include "server/ingest/measure/lod_input.h"
#include "server/ingest/mesh/node_mesh.h"

namespace lode::ingest {

/// Largest distance of an LOD from the mesh that it was made of, in lattice steps: measured at its vertices,
/// at a few points of each triangle, and at many points of the triangles near the maximum.
/// @param places  of the input's positions on the LOD; see placesOn(). @param sources  see sourcesOf().
/// @param lower_bound  smaller distances do not matter. @return at least lower_bound.
float farthestOfLod(const SimplifiedMesh& lod, const LodInput& input,
                    std::span<const SurfaceWalk::Place> places, std::span<const uint32_t> sources,
                    float lower_bound);

/// Largest distance of an LOD's edges from the mesh that it was made of, in lattice steps, to 2 %, over all
/// their points. (Clustering may make edges across a notch of the boundary or between sheets, which are close
/// to the mesh at every point that farthestOfLod() samples.)
/// @param sources  see sourcesOf(). @param lower_bound  smaller distances do not matter. @return at least
/// lower_bound.
float farthestAlongEdges(const SimplifiedMesh& lod, const LodInput& input, std::span<const uint32_t> sources,
                         float lower_bound);

}  // namespace lode::ingest
