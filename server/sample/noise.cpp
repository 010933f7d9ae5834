#include "server/sample/noise.h"

#include <array>
#include <cmath>
#include <cstddef>

namespace lode::ingest {
namespace {

constexpr std::array<std::array<float, 4>, 16> kGradients{{
    {1, 1, 0, 0},
    {-1, 1, 0, 0},
    {1, -1, 0, 0},
    {-1, -1, 0, 0},
    {1, 0, 1, 0},
    {-1, 0, 1, 0},
    {1, 0, -1, 0},
    {-1, 0, -1, 0},
    {0, 1, 1, 0},
    {0, -1, 1, 0},
    {0, 1, -1, 0},
    {0, -1, -1, 0},
    {1, 1, 0, 0},
    {-1, 1, 0, 0},
    {0, -1, 1, 0},
    {0, -1, -1, 0},
}};

/// Blends two samples; `slope` is the blend's derivative along the axis.
template <bool kGradient>
NoiseSample blend(const NoiseSample& a, const NoiseSample& b, float weight, float slope,
                  float NoiseSample::*axis) {
  const float step = b.value - a.value;
  NoiseSample result{a.value + weight * step, 0, 0, 0};
  if constexpr (kGradient) {
    result.x = a.x + weight * (b.x - a.x);
    result.y = a.y + weight * (b.y - a.y);
    result.z = a.z + weight * (b.z - a.z);
    result.*axis += slope * step;
  }
  return result;
}

float fade(float t) { return t * t * t * (t * (t * 6 - 15) + 10); }
float fadeSlope(float t) { return 30 * t * t * (t * (t - 2) + 1); }

}  // namespace

template <bool kGradient>
NoiseSample noise(const glm::dvec3& point, uint32_t seed) {
  const glm::dvec3 floor(std::floor(point.x), std::floor(point.y), std::floor(point.z));
  const float fx = static_cast<float>(point.x - floor.x);
  const float fy = static_cast<float>(point.y - floor.y);
  const float fz = static_cast<float>(point.z - floor.z);
  const uint32_t hx = static_cast<uint32_t>(static_cast<int32_t>(floor.x)) * 0x8da6b343u ^ seed;
  const uint32_t hy = static_cast<uint32_t>(static_cast<int32_t>(floor.y)) * 0xd8163841u;
  const uint32_t hz = static_cast<uint32_t>(static_cast<int32_t>(floor.z)) * 0xcb1ab31fu;
  const std::array<uint32_t, 2> xs{
      hx, (static_cast<uint32_t>(static_cast<int32_t>(floor.x)) + 1) * 0x8da6b343u ^ seed};
  const std::array<uint32_t, 2> ys{hy, hy + 0xd8163841u};
  const std::array<uint32_t, 2> zs{hz, hz + 0xcb1ab31fu};
  const auto corner = [&](size_t x, size_t y, size_t z) {
    uint32_t hash = xs[x] ^ ys[y] ^ zs[z];
    hash ^= hash >> 15;
    hash *= 0x2c1b3c6du;
    const std::array<float, 4>& g = kGradients[hash >> 28];
    const float value = g[0] * (fx - static_cast<float>(x)) + g[1] * (fy - static_cast<float>(y)) +
                        g[2] * (fz - static_cast<float>(z));
    return NoiseSample{value, g[0], g[1], g[2]};
  };
  const float u = fade(fx), v = fade(fy), w = fade(fz);
  const float du = kGradient ? fadeSlope(fx) : 0, dv = kGradient ? fadeSlope(fy) : 0,
              dw = kGradient ? fadeSlope(fz) : 0;
  const auto along_x = [&](size_t y, size_t z) {
    return blend<kGradient>(corner(0, y, z), corner(1, y, z), u, du, &NoiseSample::x);
  };
  const auto along_y = [&](size_t z) {
    return blend<kGradient>(along_x(0, z), along_x(1, z), v, dv, &NoiseSample::y);
  };
  return blend<kGradient>(along_y(0), along_y(1), w, dw, &NoiseSample::z);
}

template NoiseSample noise<false>(const glm::dvec3&, uint32_t);
template NoiseSample noise<true>(const glm::dvec3&, uint32_t);

}  // namespace lode::ingest
