#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

namespace lode::ingest {

/// Height and its gradient at a point.
struct ReliefPoint {
  double height = 0;       ///< within -0.45 .. 0.45
  glm::dvec3 gradient{0};  ///< of the height in space; zero where not asked for
  double fine_height = 0;  ///< the share of the finer half of the octaves, within -1 .. 1
};

/// Gradient noise summed over octaves: each has about twice the frequency and half the height of the one
/// before, so that the surface is equally rough at every scale.
class Relief {
 public:
  /// @param finest  no octave has a shorter wave length; an octave that begins to fit fades in.
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
