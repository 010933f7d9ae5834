#pragma once

#include <cstdint>

#include <glm/glm.hpp>

namespace lode {

/// The nearest of the normals that a payload pays least for: those whose codes are a whole number of
/// kCheapNormalSteps from the one that Draco predicts from the triangles around a vertex.
/// @param wanted  code. @param sum  of areaNormal() of those triangles.
/// @return a code at most kCheapNormalSteps / 2 away, or `wanted` where the octahedron's square has its edge.
/// Source: Draco's bitstream specification 2.2, prediction of geometric normals.
uint16_t cheapNormal(uint16_t wanted, glm::i64vec3 sum) noexcept;

/// A code is 0.7 degrees, and what an LOD's normals are off their input's some degrees.
constexpr int kCheapNormalSteps = 3;

}  // namespace lode
