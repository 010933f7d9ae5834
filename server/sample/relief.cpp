#include "server/sample/relief.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <random>

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

/// Interpolates two samples. @param slope  derivative of the weight along the axis.
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

constexpr double kFirstFrequency = 1.3;
constexpr double kFirstHeight = 0.22;
// Ratio of two octaves' frequencies; not 2, so that zeros of octaves do not coincide.
constexpr double kLacunarity = 2.03;
constexpr double kGain = 0.49;
constexpr size_t kMaxReliefOctaves = 24;

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

Relief::Relief(uint64_t seed, double finest) {
  std::mt19937_64 random(seed);
  const auto offset = [&] { return static_cast<double>(random() >> 40) * 0x1p-16; };
  double frequency = kFirstFrequency;
  double height = kFirstHeight;
  for (size_t i = 0; i < kMaxReliefOctaves && frequency * finest < 1; ++i) {
    const double fade_in = std::fmin(1, 2 * (1 - frequency * finest));
    const double x = offset(), y = offset(), z = offset();
    octaves_.push_back({frequency, height * fade_in, {x, y, z}, static_cast<uint32_t>(random())});
    frequency *= kLacunarity;
    height *= kGain;
  }
  double fine = 0;
  for (size_t i = octaves_.size() / 2; i < octaves_.size(); ++i) fine += octaves_[i].height;
  fine_scale_ = fine > 0 ? 1 / fine : 0;
}

template <bool kGradient>
ReliefPoint Relief::sum(const glm::dvec3& point) const {
  ReliefPoint result;
  double coarse = 0;
  for (size_t i = 0; i < octaves_.size(); ++i) {
    const Octave& octave = octaves_[i];
    if (i == octaves_.size() / 2) coarse = result.height;
    const NoiseSample sample = noise<kGradient>(point * octave.frequency + octave.offset, octave.seed);
    result.height += octave.height * static_cast<double>(sample.value);
    if constexpr (kGradient) {
      const double steepness = octave.height * octave.frequency;
      result.gradient += steepness * glm::dvec3(sample.x, sample.y, sample.z);
    }
  }
  result.fine_height = (result.height - coarse) * fine_scale_;
  return result;
}

template ReliefPoint Relief::sum<false>(const glm::dvec3&) const;
template ReliefPoint Relief::sum<true>(const glm::dvec3&) const;

}  // namespace lode::ingest
