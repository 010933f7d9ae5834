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
  std::optional<SurfaceSample> inside;  ///< where, if inside a triangle; near one of its corners
};

/// The largest distance of a mesh from an LOD that was made of it, in lattice steps, to 2 %: of all points of
/// those triangles that may hide the largest, as their corners and the planes of the LOD beside these say.
/// (What is passed over, LodCheck looks at; what is far along a boundary alone, boundaryGap() measures.)
/// @param surface  of the LOD.
/// @param places of the input's positions on it; see placesOn().
/// @param known  what is nearer does not matter. @return not below it.
FarthestOfInput farthestOfInput(const SimplifiedMesh& lod, const NodeMesh& input, const LodSurface& surface,
                                std::span<const SurfaceWalk::Place> places, float known);

}  // namespace lode::ingest
