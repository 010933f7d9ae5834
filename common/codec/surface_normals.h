#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/mesh.h"

namespace lode {

/// Returns the exact normal of a triangle. Its length is twice the triangle's area in square lattice steps.
glm::i64vec3 areaNormal(PositionCode a, PositionCode b, PositionCode c) noexcept;

/// Returns the octahedral code of a sum of area normals, or the code of +z if the sum is zero. Uses no fused
/// multiply-add, so that the code is the same on every machine.
uint16_t normalOf(glm::i64vec3 sum) noexcept;

/// Returns the octahedral code of each vertex's area-weighted normal.
/// @pre the mesh has at most kMaxLodTriangles triangles, so that sums do not overflow.
std::vector<uint16_t> surfaceNormals(const Mesh& mesh);

/// Encodes the list of normals that follows a payload without normals (docs/store-format.md). The list
/// contains the normals that differ from surfaceNormals() of the decoded mesh. They differ at vertices on a
/// node's border, where other nodes contain some of the triangles.
/// @param surface  code of surfaceNormals() for each vertex.
/// @param wanted   code of the normal to encode for each vertex.
std::vector<std::byte> encodeOtherNormals(std::span<const uint16_t> surface,
                                          std::span<const uint16_t> wanted);

/// Sets the normals of a mesh that was decoded without normals. First all vertices get their
/// surfaceNormals(); then the listed normals replace some of them.
/// @pre mesh.vertex_attributes has one entry per vertex.
/// @throws Error kFormat if the list is damaged.
void giveNormals(Mesh& mesh, std::span<const std::byte> others);

/// Rounds a normal to a code that Draco encodes in few bits. The returned code differs from Draco's
/// prediction by a multiple of kCheapNormalSteps.
/// @param wanted  normal code. @param sum  sum of areaNormal() of the triangles around the vertex.
/// @return a code whose coordinates differ from those of `wanted` by at most kCheapNormalSteps / 2. Returns
/// `wanted` itself at the edge of the octahedron's square, or if the prediction is far off. Source: Draco's
/// bitstream specification 2.2, prediction of geometric normals.
uint16_t cheapNormal(uint16_t wanted, glm::i64vec3 sum) noexcept;

/// Granularity of cheapNormal() in units of octahedral coordinates. A unit is about 0.7 degrees. Normals of
/// LODs differ from the normals of the input by several degrees anyway.
constexpr int kCheapNormalSteps = 3;

}  // namespace lode
