#pragma once

#include <cstdint>
#include <span>

#include "server/ingest/measure/surface_walk.h"
#include "server/ingest/mesh/node_mesh.h"
#include "server/ingest/partition/border_table.h"
#include "server/ingest/partition/normal_fans.h"

namespace lode::ingest {

/// Removes computed normals before simplification, unless a position has two. They follow from the surface,
/// so quadrics gain nothing from them; but where they separate wedges, there is a crease, which collapses
/// along itself like other seams.
NodeMesh withoutSmoothNormals(NodeMesh mesh);

/// Computes an LOD's normals if its input's are computed, so that its interpolated shading comes close to the
/// input's, separately on each side of a crease while the crease exists. A position that leaves share keeps
/// its normal bit for bit while it does not move.
/// @param lod  simplified from withoutSmoothNormals(mesh); with creases, its wedges' normals tell the sides
/// apart.
/// @param sources  see sourcesOf(). @param places  see placesOn().
void giveComputedNormals(SimplifiedMesh& lod, const NodeMesh& mesh, std::span<const uint32_t> sources,
                         std::span<const SurfaceWalk::Place> places, const CreaseAngle& crease);

/// Computes a leaf's normals, one per fan, so a position on a crease gets several wedges.
/// @param border  positions shared with other leaves; their normals come from this table.
void giveLeafNormals(NodeMesh& mesh, std::span<const BorderVertex> border, const CreaseAngle& crease);

}  // namespace lode::ingest
