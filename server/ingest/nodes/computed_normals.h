#pragma once

#include <cstdint>
#include <span>

#include "server/ingest/measure/surface_walk.h"
#include "server/ingest/mesh/node_mesh.h"
#include "server/ingest/partition/border_table.h"
#include "server/ingest/partition/normal_fans.h"

namespace lode::ingest {

/// The mesh as it is simplified: without its computed normals, where it has such and no position has two.
/// They follow from the surface, so that quadrics gain nothing from them; but where they part wedges there is
/// a crease, which collapses along itself as other seams do.
NodeMesh withoutSmoothNormals(NodeMesh mesh);

/// Gives an LOD computed normals, where the mesh that it was made of has such: those with which its shading,
/// between its corners, comes near that of the mesh, on each side of a crease by itself, as long as it is
/// one. A position that leaves share keeps its own, to the bit, while it stays where it was.
/// @param LOD  of withoutSmoothNormals(mesh): where there are creases, the normals of its wedges say which
/// side is which.
/// @param sources  see sourcesOf(). @param places  see placesOn().
void giveComputedNormals(SimplifiedMesh& lod, const NodeMesh& mesh, std::span<const uint32_t> sources,
                         std::span<const SurfaceWalk::Place> places, const CreaseAngle& crease);

/// Gives a leaf computed normals: one a fan, so that a position on a crease gets several wedges.
/// @param border  what the leaf shares with others, by position: those normals are the table's.
void giveLeafNormals(NodeMesh& mesh, std::span<const BorderVertex> border, const CreaseAngle& crease);

}  // namespace lode::ingest
