#pragma once

#include <span>

#include "server/ingest/measure/surface_walk.h"
#include "server/ingest/mesh/node_mesh.h"

namespace lode::ingest {

/// Size of the detail in colours, normals and texture coordinates that an LOD has lost against the mesh that
/// it was made of, in lattice steps: what a client must see smaller than a pixel for the picture to be right.
///
/// Of colours and normals it is the side of a triangle (of a square as large) over which the mean of the
/// input differs from the LOD's by more than 8 of 255, or by about 20 degrees (computed normals: 40); of
/// texture coordinates it is how far the picture has slid over the surface. The worst thousandth of the area
/// is left out: a single stray point asks for nothing. (docs/lod-selection.md has the measurements behind
/// these choices.)
/// @param places  of the input's positions on the LOD; see placesOn().
float lostDetail(const SimplifiedMesh& lod, const NodeMesh& input,
                 std::span<const SurfaceWalk::Place> places);

}  // namespace lode::ingest
