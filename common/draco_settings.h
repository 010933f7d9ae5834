#pragma once

#include <cmath>

#include "common/mesh.h"

/// What both halves of the Draco codec must agree on; nothing outside of them includes this.
namespace lode::draco_settings {

constexpr int kNormalBits = 8;
constexpr int kTextureBits = 16;
constexpr int kTextureStepExponent = -16;
static_assert(kTextureStep == 0x1p-16);

/// Steps outside of 2^-100 .. 2^60 have lattice points whose floats are no normal numbers.
constexpr int kMinStepExponent = -100, kMaxStepExponent = 60;

/// True for a power of two in range.
inline bool isLatticeStep(double step) noexcept {
  int exponent = 0;
  return std::frexp(step, &exponent) == 0.5 && exponent - 1 >= kMinStepExponent &&
         exponent - 1 <= kMaxStepExponent;
}

}  // namespace lode::draco_settings
