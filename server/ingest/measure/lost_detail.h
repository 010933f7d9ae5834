#pragma once

#include <span>

#include "server/ingest/measure/surface_walk.h"
#include "server/ingest/mesh/node_mesh.h"

namespace lode::ingest {

/// Size of the detail in colours, normals and texture coordinates that an LOD has lost against its input, in
/// lattice steps. The LOD looks right where this size is below one pixel.
///
/// For colours and normals, the size is the square root of the area of a triangle over which the input's mean
/// differs from the LOD's by more than 8 of 255, or by about 20 degrees (computed normals: 40). For texture
/// coordinates, the size is the distance by which the texture slides over the surface. The worst thousandth
/// of the area is ignored, so that no single stray point decides. See
/// docs/decisions/0024-appearance-error.md.
/// @param places  for each position of the input, its place on the LOD; see placesOn().
float lostDetail(const SimplifiedMesh& lod, const NodeMesh& input,
                 std::span<const SurfaceWalk::Place> places);

}  // namespace lode::ingest
