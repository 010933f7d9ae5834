#pragma once

#include <cstdint>
#include <span>

#include "server/ingest/simplified_mesh.h"

namespace lode::ingest {

/// The mesh without its computed normals, where it has such. It is simplified so: they follow from the
/// surface, so that quadrics gain nothing from them.
NodeMesh withoutComputedNormals(NodeMesh mesh);

/// Gives a rung the computed normals of the mesh that it was made of, where that has such: each of its
/// positions the mean of those that have become it, or its own, to the bit, where it has not moved.
/// @param mesh  wedges of one position share its normal. @param sources  see sourcesOf().
void giveComputedNormals(SimplifiedMesh& rung, const NodeMesh& mesh, std::span<const uint32_t> sources);

}  // namespace lode::ingest
