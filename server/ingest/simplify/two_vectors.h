#pragma once

#include <cstdint>

#include <glm/glm.hpp>

#include "server/ingest/mesh/four_vectors.h"

namespace lode::ingest {

/// Two numbers that are reckoned with at once, as Four is.
using Two = double __attribute__((vector_size(16)));
/// What comparing two twos gives.
using TwoTruths = int64_t __attribute__((vector_size(16)));

inline Two twoOf(double value) noexcept { return Two{value, value}; }
inline Two larger(Two a, Two b) noexcept { return a > b ? a : b; }
inline bool anyOf(TwoTruths truths) noexcept { return (truths[0] | truths[1]) != 0; }

struct TwoVectors {
  TwoVectors(Two of_x, Two of_y, Two of_z) noexcept : x(of_x), y(of_y), z(of_z) {}
  TwoVectors(glm::dvec3 a, glm::dvec3 b) noexcept : x{a.x, b.x}, y{a.y, b.y}, z{a.z, b.z} {}
  /// The first two of four, or the last.
  TwoVectors(const FourVectors& four, bool last) noexcept
      : x(half(four.x, last)), y(half(four.y, last)), z(half(four.z, last)) {}

  Two x, y, z;

 private:
  static Two half(Four four, bool last) noexcept {
    using Half = float __attribute__((vector_size(8)));
    return last ? __builtin_convertvector(__builtin_shufflevector(four, four, 2, 3), Two)
                : __builtin_convertvector((Half{four[0], four[1]}), Two);
  }
};

inline TwoVectors operator-(const TwoVectors& a, const TwoVectors& b) noexcept {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Two dot(const TwoVectors& a, const TwoVectors& b) noexcept {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline TwoVectors cross(const TwoVectors& a, const TwoVectors& b) noexcept {
  return {a.y * b.z - b.y * a.z, a.z * b.x - b.z * a.x, a.x * b.y - b.x * a.y};
}

}  // namespace lode::ingest
