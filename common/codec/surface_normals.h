#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/mesh.h"

namespace lode {

/// A triangle's normal, twice as long as it has area in square steps. Exact.
glm::i64vec3 areaNormal(PositionCode a, PositionCode b, PositionCode c) noexcept;

/// The code of a sum of such normals; +z for none. In double and float, nothing fused: the same on every
/// machine.
uint16_t normalOf(glm::i64vec3 sum) noexcept;

/// The normals that a mesh's triangles give its vertices, weighed by their areas: a code a vertex.
/// @pre at most kMaxLodTriangles, or sums overflow.
std::vector<uint16_t> surfaceNormals(const Mesh& mesh);

/// What surfaceNormals() of a decoded mesh get wrong, as a payload that has no normals lists it
/// (docs/store-format.md): vertices on the borders of nodes, whose surface goes on elsewhere.
/// @param surface, wanted  codes, one a vertex.
std::vector<std::byte> encodeOtherNormals(std::span<const uint16_t> surface,
                                          std::span<const uint16_t> wanted);

/// Gives a mesh that was decoded without normals its surface's, then those that are listed.
/// @pre it has attributes for each vertex.
/// @throws Error kFormat where the list is damaged.
void giveNormals(Mesh& mesh, std::span<const std::byte> others);

}  // namespace lode
