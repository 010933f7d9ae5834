#include "server/sample/relief.h"

#include <cmath>
#include <random>

#include "server/sample/noise.h"

namespace lode::ingest {
namespace {

constexpr double kFirstFrequency = 1.3;
constexpr double kFirstHeight = 0.22;
constexpr double kLacunarity = 2.03;  // not 2, so that the zeros of the octaves do not fall together
constexpr double kGain = 0.49;
constexpr size_t kMaxReliefOctaves = 24;

}  // namespace

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
