#pragma once

#include <cstdint>
#include <span>

#include "server/ingest/measure/surface_walk.h"
#include "server/ingest/mesh/node_mesh.h"
#include "server/ingest/partition/border_table.h"
#include "server/ingest/partition/normal_fans.h"

namespace lode::ingest {

/// Removes computed normals before simplification, unless some position has two normals. Computed normals
/// follow from the surface, so they would add no information to the quadric errors. Two normals at one
/// position mark a crease, which must collapse along itself like other seams.
NodeMesh withoutSmoothNormals(NodeMesh mesh);

/// Computes an LOD's normals if the normals of its input are computed. Chooses normals that reproduce the
/// input's shading closely when they are interpolated over the LOD's triangles. Treats the two sides of a
/// crease separately. A position that several leaves share keeps exactly the same normal until the position
/// moves.
/// @param lod  mesh that was simplified from withoutSmoothNormals(mesh). The normals of its wedges
/// distinguish the sides of creases.
/// @param sources  see sourcesOf(). @param places  see placesOn().
void giveComputedNormals(SimplifiedMesh& lod, const NodeMesh& mesh, std::span<const uint32_t> sources,
                         std::span<const SurfaceWalk::Place> places, const CreaseAngle& crease);

/// Computes the normals of a leaf, one per fan of triangles (see NormalFans). A position on a crease gets
/// several wedges.
/// @param border  positions that the leaf shares with other leaves, with the normals to use there.
void giveLeafNormals(NodeMesh& mesh, std::span<const BorderVertex> border, const CreaseAngle& crease);

}  // namespace lode::ingest
