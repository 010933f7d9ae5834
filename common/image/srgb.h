#pragma once

#include <cstdint>

namespace lode {

/// Colours are stored as sRGB (IEC 61966-2-1) and mixed as linear light, 0 to 1.
double linearOf(uint8_t srgb) noexcept;
/// The nearest. @param linear  beyond 0 to 1 it is clamped.
uint8_t srgbOf(double linear) noexcept;

}  // namespace lode
