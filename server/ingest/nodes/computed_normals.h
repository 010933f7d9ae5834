#pragma once

#include <cstdint>
#include <span>

#include "server/ingest/measure/surface_walk.h"
#include "server/ingest/mesh/node_mesh.h"
#include "server/ingest/partition/border_table.h"
#include "server/ingest/partition/normal_fans.h"

namespace lode::ingest {

/// Removes computed normals before simplification, unless some position has two. Computed normals follow from
/// the surface, so they would not improve the quadrics. But if two normals at one position separate wedges,
/// the wedges mark a crease, which must collapse along itself like other seams.
NodeMesh withoutSmoothNormals(NodeMesh mesh);

/// Computes an LOD's normals if the normals of its input are computed. Chooses normals whose interpolation
/// comes close to the input's shading; as long as a crease exists, treats its sides separately. A position
/// that leaves share keeps exactly the same normal as long as it does not move.
/// @param lod  simplified from withoutSmoothNormals(mesh); if there are creases, the normals of the LOD's
/// wedges tell the sides apart.
/// @param sources  see sourcesOf(). @param places  see placesOn().
void giveComputedNormals(SimplifiedMesh& lod, const NodeMesh& mesh, std::span<const uint32_t> sources,
                         std::span<const SurfaceWalk::Place> places, const CreaseAngle& crease);

/// Computes a leaf's normals, one per fan of triangles, so a position on a crease gets several wedges.
/// @param border  positions that the leaf shares with other leaves, with the normals that they get.
void giveLeafNormals(NodeMesh& mesh, std::span<const BorderVertex> border, const CreaseAngle& crease);

}  // namespace lode::ingest
