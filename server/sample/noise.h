#pragma once

#include <cstdint>

#include <glm/glm.hpp>

namespace lode::ingest {

/// Value of the noise, within -1 .. 1, and its gradient.
struct NoiseSample {
  float value, x, y, z;
};

/// Gradient noise: smooth, zero at every integer point, with features of about unit size. Source: Perlin,
/// Improving Noise, 2002; the gradients lie at the edges of a cube, chosen by an integer hash.
/// @tparam kGradient  whether the gradient is asked for; its members are zero otherwise.
template <bool kGradient>
NoiseSample noise(const glm::dvec3& point, uint32_t seed);

}  // namespace lode::ingest
