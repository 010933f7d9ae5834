#pragma once

#include <span>

#include "server/ingest/measure/surface_walk.h"
#include "server/ingest/mesh/node_mesh.h"

namespace lode::ingest {

/// Returns the size of the colour, normal and texture detail that an LOD has lost against its input, in
/// lattice steps. The LOD looks right if this size covers less than a pixel on the screen.
///
/// For colours and normals, a triangle of the LOD counts if its mean difference from the input exceeds 8 of
/// 255, or about 20 degrees (40 for computed normals). The size is then the square root of the triangle's
/// area. For texture coordinates, the size is the distance by which the texture slides over the surface. The
/// worst thousandth of the LOD's area is ignored, so that no single point determines the result. See
/// docs/decisions/0024-appearance-error.md.
/// @param places  for each position of the input, its place on the LOD; see placesOn().
float lostDetail(const SimplifiedMesh& lod, const NodeMesh& input,
                 std::span<const SurfaceWalk::Place> places);

}  // namespace lode::ingest
