#pragma once

#include <cstdint>

#include <glm/glm.hpp>

namespace lode::ingest {

/// Four floats for SIMD; a vector extension of GCC and Clang.
using Four = float __attribute__((vector_size(16)));
/// Comparison result of two Fours.
using FourTruths = int32_t __attribute__((vector_size(16)));

inline Four fourOf(float value) noexcept { return Four{value, value, value, value}; }
// Use intrinsics, because compilers do not always find the single instruction for a minimum or maximum.
#ifdef __SSE__
inline Four smaller(Four a, Four b) noexcept { return __builtin_ia32_minps(a, b); }
inline Four larger(Four a, Four b) noexcept { return __builtin_ia32_maxps(a, b); }
#else
inline Four smaller(Four a, Four b) noexcept { return a < b ? a : b; }
inline Four larger(Four a, Four b) noexcept { return a > b ? a : b; }
#endif
inline bool anyOf(FourTruths truths) noexcept {
  using Halves = int64_t __attribute__((vector_size(16)));
  const auto halves = reinterpret_cast<Halves>(truths);
  return (halves[0] | halves[1]) != 0;
}

/// Returns a mask with one bit per lane, set if the lane is true; bit 0 belongs to lane 0.
inline unsigned bitsOf(FourTruths truths) noexcept {
#ifdef __SSE__
  return static_cast<unsigned>(__builtin_ia32_movmskps(reinterpret_cast<Four>(truths)));
#else
  return (truths[0] & 1u) | (truths[1] & 2u) | (truths[2] & 4u) | (truths[3] & 8u);
#endif
}
inline float leastOf(Four four) noexcept {
  const Four swapped = __builtin_shufflevector(four, four, 1, 0, 3, 2), pairs = smaller(four, swapped);
  return pairs[0] < pairs[2] ? pairs[0] : pairs[2];
}

struct FourVectors {
  FourVectors() = default;
  FourVectors(Four of_x, Four of_y, Four of_z) noexcept : x(of_x), y(of_y), z(of_z) {}
  explicit FourVectors(glm::vec3 all) noexcept : x(fourOf(all.x)), y(fourOf(all.y)), z(fourOf(all.z)) {}
  FourVectors(glm::vec3 a, glm::vec3 b, glm::vec3 c, glm::vec3 d) noexcept
      : x{a.x, b.x, c.x, d.x}, y{a.y, b.y, c.y, d.y}, z{a.z, b.z, c.z, d.z} {}
  /// Makes vectors from the first three components of each argument.
  FourVectors(Four a, Four b, Four c, Four d) noexcept {
    const Four ab = __builtin_shufflevector(a, b, 0, 4, 1, 5), cd = __builtin_shufflevector(c, d, 0, 4, 1, 5),
               ab_z = __builtin_shufflevector(a, b, 2, 6, 2, 6),
               cd_z = __builtin_shufflevector(c, d, 2, 6, 2, 6);
    x = __builtin_shufflevector(ab, cd, 0, 1, 4, 5);
    y = __builtin_shufflevector(ab, cd, 2, 3, 6, 7);
    z = __builtin_shufflevector(ab_z, cd_z, 0, 1, 4, 5);
  }

  Four x{}, y{}, z{};
};

inline FourVectors operator+(const FourVectors& a, const FourVectors& b) noexcept {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline FourVectors operator-(const FourVectors& a, const FourVectors& b) noexcept {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline FourVectors operator*(Four by, const FourVectors& a) noexcept {
  return {by * a.x, by * a.y, by * a.z};
}
inline FourVectors operator/(const FourVectors& a, Four by) noexcept {
  return {a.x / by, a.y / by, a.z / by};
}
inline Four dot(const FourVectors& a, const FourVectors& b) noexcept {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline FourVectors cross(const FourVectors& a, const FourVectors& b) noexcept {
  return {a.y * b.z - b.y * a.z, a.z * b.x - b.z * a.x, a.x * b.y - b.x * a.y};
}

}  // namespace lode::ingest
