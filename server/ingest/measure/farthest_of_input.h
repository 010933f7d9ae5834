#pragma once

#include <optional>
#include <span>

#include "server/ingest/measure/lod_surface.h"
#include "server/ingest/measure/surface_samples.h"
#include "server/ingest/measure/surface_walk.h"
#include "server/ingest/mesh/node_mesh.h"

namespace lode::ingest {

struct FarthestOfInput {
  float steps = 0;
  /// Farthest point, if it lies inside a triangle; empty if it is a position of the input. `near` is a corner
  /// of the triangle.
  std::optional<SurfaceSample> inside;
};

/// Returns the largest distance from a point of an input mesh to an LOD that was made from it, in lattice
/// steps, to 2 %. Measures only triangles that may contain the farthest point, judging by the distances of
/// their corners and by the planes of the LOD near the corners. (LodCheck measures all triangles;
/// boundaryGap() compares the boundaries.)
/// @param surface  the LOD's surface.
/// @param places  for each position of the input, its place on the LOD; see placesOn().
/// @param lower_bound  the function ignores smaller distances. @return at least lower_bound.
FarthestOfInput farthestOfInput(const SimplifiedMesh& lod, const NodeMesh& input, const LodSurface& surface,
                                std::span<const SurfaceWalk::Place> places, float lower_bound);

}  // namespace lode::ingest
