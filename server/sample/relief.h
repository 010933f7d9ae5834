#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

namespace lode::ingest {

/// Noise value in -1..1 and its gradient.
struct NoiseSample {
  float value, x, y, z;
};

/// Computes gradient noise, which is smooth, zero at integer points, and has features of about unit size. An
/// integer hash chooses the gradients. Source: Perlin, Improving Noise, 2002. @tparam kGradient true computes
/// the gradient; false returns zero as gradient.
template <bool kGradient>
NoiseSample noise(const glm::dvec3& point, uint32_t seed);

/// Height at a point and its gradient in space.
struct ReliefPoint {
  double height = 0;       ///< height in -0.45..0.45
  glm::dvec3 gradient{0};  ///< gradient of the height; zero if not requested
  double fine_height = 0;  ///< sum of the finer half of the octaves, scaled to -1..1
};

/// Sum of octaves of gradient noise. Each octave has about twice the frequency and half the height of the
/// previous one, so the surface is equally rough at every scale.
class Relief {
 public:
  /// @param finest  shortest wavelength; octaves near this wavelength are weakened.
  Relief(uint64_t seed, double finest);

  ReliefPoint at(const glm::dvec3& point) const { return sum<false>(point); }
  ReliefPoint atWithGradient(const glm::dvec3& point) const { return sum<true>(point); }

 private:
  struct Octave {
    double frequency;
    double height;
    glm::dvec3 offset;
    uint32_t seed;
  };

  template <bool kGradient>
  ReliefPoint sum(const glm::dvec3& point) const;

  std::vector<Octave> octaves_;
  double fine_scale_ = 0;
};

}  // namespace lode::ingest
