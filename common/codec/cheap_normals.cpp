#include "common/codec/cheap_normals.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace lode {
namespace {

constexpr int kMiddle = 127, kEnd = 2 * kMiddle;
constexpr int64_t kLargestSum = 1 << 29;
constexpr int kFar = kMiddle / 2;  ///< the prediction tells nothing

int64_t sumOf(glm::i64vec3 v) noexcept { return std::abs(v.x) + std::abs(v.y) + std::abs(v.z); }

/// As Draco does, which rounds towards zero.
glm::ivec2 predicted(glm::i64vec3 sum) noexcept {
  if (sumOf(sum) > kLargestSum) sum /= sumOf(sum) / kLargestSum;
  glm::ivec3 p(kMiddle, 0, 0);
  if (const int64_t length = sumOf(sum); length > 0) {
    p.x = static_cast<int>(sum.x * kMiddle / length);
    p.y = static_cast<int>(sum.y * kMiddle / length);
    p.z = kMiddle - std::abs(p.x) - std::abs(p.y);
    if (sum.z < 0) p.z = -p.z;
  }
  if (p.x >= 0) return {p.y + kMiddle, p.z + kMiddle};
  return {p.y < 0 ? std::abs(p.z) : kEnd - std::abs(p.z), p.z < 0 ? std::abs(p.y) : kEnd - std::abs(p.y)};
}

int roundedToSteps(int off) noexcept {
  return kCheapNormalSteps * static_cast<int>(std::lround(static_cast<double>(off) / kCheapNormalSteps));
}

}  // namespace

uint16_t cheapNormal(uint16_t wanted, glm::i64vec3 sum) noexcept {
  const glm::ivec2 code(wanted & 255, wanted >> 8), from = predicted(sum), off = code - from;
  if (std::max(std::abs(off.x), std::abs(off.y)) > kFar) return wanted;
  const glm::ivec2 cheap = from + glm::ivec2(roundedToSteps(off.x), roundedToSteps(off.y));
  const bool is_at_edge = std::min(cheap.x, cheap.y) < 1 ||
                          std::max(cheap.x, cheap.y) >= kEnd;  // where two codes are one direction
  return is_at_edge ? wanted : static_cast<uint16_t>(cheap.x | cheap.y << 8);
}

}  // namespace lode
