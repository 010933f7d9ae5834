#include "server/ingest/simplify/lattice_places.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace lode::ingest {
namespace {

// Largest spacing of candidate points, relative to the mean edge length (kOfEdge) and to the error of the
// collapse (kOfError).
constexpr double kOfEdge = 1.0 / 32, kOfError = 2;
constexpr double kAreaOfEdge = 0.433;  ///< area of an equilateral triangle with side 1

/// Returns the largest power of two that is at most `value`; 0 for subnormal values. @param value  not
/// negative
double powerOfTwoAtMost(double value) noexcept {
  constexpr uint64_t kExponent = 0x7FF0000000000000u;
  return std::bit_cast<double>(std::bit_cast<uint64_t>(value) & kExponent);
}

/// Returns floor(p) for values that fit a 64-bit integer. This function is faster than the library's floor(),
/// because it is inlined.
glm::dvec3 floorOf(glm::dvec3 p) noexcept {
  glm::dvec3 floor{glm::i64vec3(p)};
  for (int k = 0; k < 3; ++k) floor[k] -= floor[k] > p[k];
  return floor;
}

/// Returns the index of the smallest value, or the first such index if several values are equal. Uses no
/// branch, because the processor cannot predict branches on random costs.
uint32_t firstOfLeast(const std::array<double, 8>& values) noexcept {
  const double least =
      std::min({values[0], values[1], values[2], values[3], values[4], values[5], values[6], values[7]});
  uint32_t places = 0;
  for (uint32_t i = 0; i < values.size(); ++i) places |= static_cast<uint32_t>(values[i] == least) << i;
  return static_cast<uint32_t>(std::countr_zero(places)) % 8;
}

double areaOf(const CollapseMesh& mesh) {
  double twice = 0;
  for (size_t t = 0; t < mesh.corner_position.size(); t += 4) {
    const auto at = [&](size_t k) { return mesh.point(mesh.corner_position[t + k]); };
    twice += glm::length(glm::cross(at(1) - at(0), at(2) - at(0)));
  }
  return twice / 2;
}

}  // namespace

LatticePlaces::LatticePlaces(const CollapseMesh& mesh, glm::dvec3 highest)
    : lowest_(-mesh.origin),
      highest_(highest - mesh.origin),
      area_(areaOf(mesh)),
      taken_(mesh.positions.size()) {
  for (uint32_t i = 0; i < mesh.positions.size(); ++i) taken_.add(mesh.point(i));
}

void LatticePlaces::aimFor(size_t triangles) {
  const double edge = std::sqrt(area_ / kAreaOfEdge / static_cast<double>(std::max<size_t>(triangles, 1)));
  coarsest_ = std::max(powerOfTwoAtMost(kOfEdge * edge), 1.0);
}

glm::dvec3 LatticePlaces::settle(glm::dvec3 point, const Quadric& q, double off, glm::dvec3 at_u,
                                 glm::dvec3 at_v) const {
  if (point == at_u || point == at_v) return point;
  const double s = std::clamp(powerOfTwoAtMost(kOfError * off), 1.0, coarsest_);
  const glm::dvec3 low = s * floorOf((1 / s) * (point - lowest_)) + lowest_;
  const glm::dvec3 gradient = 2.0 * (q.timesA(low) + q.b);
  // Costs of the eight candidate points, relative to the cost of `low`.
  const double x = s * (s * q.xx + gradient.x), y = s * (s * q.yy + gradient.y),
               z = s * (s * q.zz + gradient.z);
  const double xy = 2 * s * s * q.xy, xz = 2 * s * s * q.xz, yz = 2 * s * s * q.yz;
  std::array<double, 8> costs{0, x, y, x + y + xy, z, x + z + xz, y + z + yz, x + y + z + xy + xz + yz};
  for (size_t tried = 0; tried < costs.size(); ++tried) {
    const uint32_t bits = firstOfLeast(costs);
    costs[bits] = std::numeric_limits<double>::infinity();
    const glm::dvec3 place =
        glm::clamp(low + s * glm::dvec3(bits & 1, bits >> 1 & 1, bits >> 2), lowest_, highest_);
    if (place == at_u || place == at_v || !taken_.contains(place)) return place;
  }
  return q.at(at_u) < q.at(at_v) ? at_u : at_v;
}

}  // namespace lode::ingest
