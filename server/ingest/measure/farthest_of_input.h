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
  std::optional<SurfaceSample>
      inside;  ///< the farthest point if it is inside a triangle; near one of its corners
};

/// Largest distance of a mesh from an LOD made of it, in lattice steps, to 2 %. Measures only triangles that
/// may contain it, judging by their corners and the LOD's planes there. (LodCheck measures all triangles;
/// boundaryGap() covers points that are far along a boundary.)
/// @param surface  of the LOD.
/// @param places  of the input's positions on the LOD; see placesOn().
/// @param lower_bound  smaller distances do not matter. @return at least lower_bound.
FarthestOfInput farthestOfInput(const SimplifiedMesh& lod, const NodeMesh& input, const LodSurface& surface,
                                std::span<const SurfaceWalk::Place> places, float lower_bound);

}  // namespace lode::ingest
