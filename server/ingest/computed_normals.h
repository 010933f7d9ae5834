#pragma once

#include <cstdint>
#include <span>

#include "server/ingest/simplified_mesh.h"
#include "server/ingest/surface_walk.h"

namespace lode::ingest {

/// Whether a mesh's attributes are one computed normal a position. It is simplified without them: they follow
/// from the surface, so that quadrics gain nothing from them.
bool hasComputedNormalsAlone(const NodeMesh& mesh) noexcept;

/// The mesh without its attributes.
/// @param mesh  with one wedge a position, of its number.
NodeMesh withoutAttributes(NodeMesh mesh);

/// Gives a rung the normals of the mesh that it was made of: each of its positions that of the nearest place,
/// to the bit where it has not moved.
/// @param mesh  see hasComputedNormalsAlone(). @param walk  over it. @param sources  see sourcesOf().
void giveComputedNormals(SimplifiedMesh& rung, const NodeMesh& mesh, const SurfaceWalk& walk,
                         std::span<const uint32_t> sources);

}  // namespace lode::ingest
