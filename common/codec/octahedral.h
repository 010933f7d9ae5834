#pragma once

#include <cstdint>

#include <glm/glm.hpp>

namespace lode {

/// Whether a vector points anywhere: it is finite and not zero.
bool hasDirection(glm::vec3 vector) noexcept;

/// Octahedral code of a direction: 8 bits a coordinate, u low byte, v high byte, on the same grid as Draco's
/// 8-bit octahedral quantization (values 0..254, centre 127), so that a payload gives back the code it was
/// made from.
/// @param normal need not be of unit length; one without a direction gives the code of +z.
/// Source: Meyer et al., On Floating-Point Normal Vectors, 2010;
/// draco/compression/attributes/normal_compression_utils.h.
uint16_t encodeOctahedral(glm::vec3 normal) noexcept;

/// The unit vector of a code.
glm::vec3 decodeOctahedral(uint16_t code) noexcept;

}  // namespace lode
