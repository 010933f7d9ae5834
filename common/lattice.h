#pragma once

#include <algorithm>
#include <cmath>
#include <compare>
#include <cstdint>

#include <glm/glm.hpp>

namespace lode {

constexpr int kLatticeBits = 21;                            ///< bits of a lattice coordinate
constexpr uint32_t kMaxLattice = (1u << kLatticeBits) - 1;  ///< largest lattice coordinate

/// A vertex position: three lattice coordinates in 63 bits, with x in the lowest bits. Payloads preserve
/// position codes exactly, so equal codes identify equal vertices everywhere: in the build's triangles,
/// across nodes and in clients.
struct PositionCode {
  uint64_t value = 0;
  friend constexpr auto operator<=>(PositionCode, PositionCode) = default;
};

inline PositionCode packPosition(glm::uvec3 p) noexcept {
  return {p.x | static_cast<uint64_t>(p.y) << kLatticeBits | static_cast<uint64_t>(p.z) << 2 * kLatticeBits};
}

inline glm::uvec3 unpackPosition(PositionCode code) noexcept {
  return {code.value & kMaxLattice, code.value >> kLatticeBits & kMaxLattice,
          code.value >> 2 * kLatticeBits & kMaxLattice};
}

/// Axis-aligned box of lattice coordinates. Contains both min and max; empty if min > max.
struct LatticeBox {
  glm::uvec3 min{kMaxLattice};
  glm::uvec3 max{0};

  bool operator==(const LatticeBox&) const = default;
  bool empty() const noexcept { return min.x > max.x; }
  void add(glm::uvec3 p) noexcept {
    min = glm::min(min, p);
    max = glm::max(max, p);
  }
  void add(const LatticeBox& other) noexcept {
    min = glm::min(min, other.min);
    max = glm::max(max, other.max);
  }
  bool contains(const LatticeBox& other) const noexcept {
    return glm::all(glm::lessThanEqual(min, other.min)) && glm::all(glm::greaterThanEqual(max, other.max));
  }
};

/// Smallest and largest step. Outside this range, the float coordinates of lattice points could be subnormal
/// or infinite.
constexpr double kMinStep = 0x1p-100, kMaxStep = 0x1p60;

/// Returns true if a step is 4, 5, 6 or 7 times a power of two and lies between kMinStep and kMaxStep. The
/// product of such a step and a lattice coordinate is exact in float, because it has at most 3 + 21
/// significant bits.
inline bool isLatticeStep(double step) noexcept {
  int exponent = 0;
  const double eighths = 8 * std::frexp(step, &exponent);
  return step >= kMinStep && step <= kMaxStep && eighths == std::floor(eighths);
}

/// The grid on which every vertex of a model lies. True coordinates are origin + step * lattice coordinates.
/// Coordinates in the model frame are step * lattice coordinates, which floats represent exactly.
struct Lattice {
  glm::dvec3 origin{0};  ///< true coordinates of lattice point (0,0,0); a multiple of the step
  double step = 1;       ///< distance between neighbouring lattice points in true units, see isLatticeStep()

  bool operator==(const Lattice&) const = default;
  /// Returns the nearest lattice point, computed in double and clamped to the grid. No other code
  /// rounds positions.
  glm::uvec3 snap(glm::dvec3 world) const noexcept {
    const glm::dvec3 steps = glm::clamp(glm::round((world - origin) / step), 0.0, double(kMaxLattice));
    return glm::uvec3(steps);
  }
  glm::vec3 toModel(glm::uvec3 p) const noexcept { return glm::vec3(p) * static_cast<float>(step); }
  glm::dvec3 toWorld(glm::uvec3 p) const noexcept { return origin + step * glm::dvec3(p); }
};

}  // namespace lode
