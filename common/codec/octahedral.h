#pragma once

#include <cstdint>

#include <glm/glm.hpp>

namespace lode {

/// Returns true if a vector is finite and not zero.
bool hasDirection(glm::vec3 vector) noexcept;

/// Returns the octahedral code of a direction, with u in the low byte and v in the high byte. The code lies
/// on the grid of Draco's 8-bit octahedral quantization (0..254, centre 127), so that Draco preserves the
/// code.
/// @param normal  vector of any length. A vector without a direction gets the code of +z.
/// Source: Meyer et al., On Floating-Point Normal Vectors, 2010;
/// draco/compression/attributes/normal_compression_utils.h.
uint16_t encodeOctahedral(glm::vec3 normal) noexcept;

/// Returns the unit vector of a code.
glm::vec3 decodeOctahedral(uint16_t code) noexcept;

}  // namespace lode
