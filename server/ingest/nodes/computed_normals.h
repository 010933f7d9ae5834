#pragma once

#include <cstdint>
#include <span>

#include "server/ingest/measure/surface_walk.h"
#include "server/ingest/mesh/simplified_mesh.h"

namespace lode::ingest {

/// The mesh without its computed normals, where it has such. It is simplified so: they follow from the
/// surface, so that quadrics gain nothing from them.
NodeMesh withoutComputedNormals(NodeMesh mesh);

/// Gives a rung computed normals, where the mesh that it was made of has such: those with which its shading,
/// between its corners, comes near that of the mesh. A position that leaves share keeps its own, to the bit,
/// while it stays where it was.
/// @param mesh  wedges of one position share its normal. @param sources  see sourcesOf(). @param places  see
/// placesOn().
void giveComputedNormals(SimplifiedMesh& rung, const NodeMesh& mesh, std::span<const uint32_t> sources,
                         std::span<const SurfaceWalk::Place> places);

}  // namespace lode::ingest
