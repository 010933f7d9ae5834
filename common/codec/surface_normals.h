#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/mesh.h"

namespace lode {

/// Returns a triangle's normal. Its length is twice the area in square lattice steps. Exact.
glm::i64vec3 areaNormal(PositionCode a, PositionCode b, PositionCode c) noexcept;

/// Returns the octahedral code of a sum of areaNormal(); that of +z for a zero sum. Computed without fused
/// multiply-add: the same on every machine.
uint16_t normalOf(glm::i64vec3 sum) noexcept;

/// Returns the area-weighted normal of each vertex, as codes.
/// @pre at most kMaxLodTriangles triangles, or sums overflow.
std::vector<uint16_t> surfaceNormals(const Mesh& mesh);

/// Encodes the normals that differ from surfaceNormals() of the decoded mesh, as payloads without normals
/// list them (docs/store-format.md). They belong to vertices at boundaries of nodes, whose other triangles
/// are in other nodes.
/// @param surface, wanted  codes, one per vertex.
std::vector<std::byte> encodeOtherNormals(std::span<const uint16_t> surface,
                                          std::span<const uint16_t> wanted);

/// Sets the normals of a mesh that was decoded without normals: surfaceNormals(), then the listed ones.
/// @pre each vertex has attributes.
/// @throws Error kFormat if the list is damaged.
void giveNormals(Mesh& mesh, std::span<const std::byte> others);

/// Rounds a normal to one that Draco encodes in few bits: its code differs from Draco's prediction by a
/// multiple of kCheapNormalSteps.
/// @param wanted  code. @param sum  sum of areaNormal() of the triangles around the vertex.
/// @return a code at most kCheapNormalSteps / 2 away, or `wanted` at the edge of the octahedron's square.
/// Source: Draco's bitstream specification 2.2, prediction of geometric normals.
uint16_t cheapNormal(uint16_t wanted, glm::i64vec3 sum) noexcept;

/// A step is 0.7 degrees; normals of LODs differ from the input's by several degrees.
constexpr int kCheapNormalSteps = 3;

}  // namespace lode
