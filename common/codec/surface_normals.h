#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/mesh.h"

namespace lode {

/// Returns a triangle's normal. The normal's length is twice the area in square lattice steps. Exact.
glm::i64vec3 areaNormal(PositionCode a, PositionCode b, PositionCode c) noexcept;

/// Returns the octahedral code of a sum of areaNormal(), or the code of +z if the sum is zero. Uses no fused
/// multiply-add, so that the code is the same on every machine.
uint16_t normalOf(glm::i64vec3 sum) noexcept;

/// Returns the octahedral code of each vertex's area-weighted normal.
/// @pre the mesh has at most kMaxLodTriangles triangles, so that sums do not overflow.
std::vector<uint16_t> surfaceNormals(const Mesh& mesh);

/// Encodes the normals that differ from surfaceNormals() of the decoded mesh, as payloads without normals
/// list them (docs/store-format.md). Normals differ at vertices on boundaries of nodes, because some
/// triangles around such a vertex are in other nodes.
/// @param surface, wanted  normal codes, one per vertex.
std::vector<std::byte> encodeOtherNormals(std::span<const uint16_t> surface,
                                          std::span<const uint16_t> wanted);

/// Sets the normals of a mesh that was decoded without normals: first surfaceNormals(), then the listed
/// normals.
/// @pre each vertex has attributes.
/// @throws Error kFormat if the list is damaged.
void giveNormals(Mesh& mesh, std::span<const std::byte> others);

/// Rounds a normal to a normal that Draco encodes in few bits, because the code differs from Draco's
/// prediction by a multiple of kCheapNormalSteps.
/// @param wanted  normal code. @param sum  sum of areaNormal() of the triangles around the vertex.
/// @return a code whose coordinates differ from `wanted` by at most kCheapNormalSteps / 2, or `wanted` itself
/// at the edge of the octahedron's square and far from the prediction. Source: Draco's bitstream
/// specification 2.2, prediction of geometric normals.
uint16_t cheapNormal(uint16_t wanted, glm::i64vec3 sum) noexcept;

/// Granularity of cheapNormal() in steps of octahedral codes. A step is 0.7 degrees, while normals of LODs
/// differ from the input's by several degrees.
constexpr int kCheapNormalSteps = 3;

}  // namespace lode
