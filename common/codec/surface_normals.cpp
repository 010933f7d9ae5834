#include "common/codec/surface_normals.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "common/codec/draco_stream.h"
#include "common/codec/octahedral.h"

namespace lode {
namespace {

using draco_stream::refuse;

constexpr int kNibbleBias = 8;  ///< offset that maps a difference from -8 to 7 to four unsigned bits

glm::ivec2 fromCode(uint16_t code) noexcept { return {code & 255, code >> 8}; }

void putVarint(std::vector<std::byte>& out, uint32_t value) {
  for (; value >= 128; value >>= 7) out.push_back(static_cast<std::byte>(value | 128));
  out.push_back(static_cast<std::byte>(value));
}

constexpr int kMiddle = 127, kEnd = 2 * kMiddle;
constexpr int64_t kLargestSum = 1 << 29;
constexpr int kFar = kMiddle / 2;  ///< largest difference between a normal and a useful prediction

int64_t sumOf(glm::i64vec3 v) noexcept { return std::abs(v.x) + std::abs(v.y) + std::abs(v.z); }

/// Returns the coordinates of the code that Draco predicts; Draco rounds towards zero.
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

glm::i64vec3 areaNormal(PositionCode a, PositionCode b, PositionCode c) noexcept {
  const glm::i64vec3 from(unpackPosition(a));
  const glm::i64vec3 u = glm::i64vec3(unpackPosition(b)) - from, v = glm::i64vec3(unpackPosition(c)) - from;
  return {u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x};
}

uint16_t normalOf(glm::i64vec3 sum) noexcept {
  const glm::dvec3 exact(sum);
  const double length = glm::length(exact);
  return encodeOctahedral(length > 0 ? glm::vec3(exact / length) : glm::vec3(0, 0, 1));
}

std::vector<uint16_t> surfaceNormals(const Mesh& mesh) {
  std::vector<glm::i64vec3> sums(mesh.positions.size(), glm::i64vec3(0));
  for (const glm::u32vec3& t : mesh.triangles) {
    const glm::i64vec3 normal = areaNormal(mesh.positions[t.x], mesh.positions[t.y], mesh.positions[t.z]);
    for (int k = 0; k < 3; ++k) sums[t[k]] += normal;
  }
  std::vector<uint16_t> normals;
  normals.reserve(sums.size());
  for (const glm::i64vec3& sum : sums) normals.push_back(normalOf(sum));
  return normals;
}

std::vector<std::byte> encodeOtherNormals(std::span<const uint16_t> surface,
                                          std::span<const uint16_t> wanted) {
  std::vector<std::byte> out;
  uint32_t next = 0;
  for (uint32_t v = 0; v < wanted.size(); ++v) {
    if (surface[v] == wanted[v]) continue;
    const glm::ivec2 off = fromCode(wanted[v]) - fromCode(surface[v]) + kNibbleBias;
    const bool is_far = ((off.x | off.y) & ~15) != 0;
    putVarint(out, (v - next) << 1 | (is_far ? 1 : 0));
    if (is_far) {
      out.push_back(static_cast<std::byte>(wanted[v]));
      out.push_back(static_cast<std::byte>(wanted[v] >> 8));
    } else {
      out.push_back(static_cast<std::byte>(off.x | off.y << 4));
    }
    next = v + 1;
  }
  return out;
}

void giveNormals(Mesh& mesh, std::span<const std::byte> others) {
  const std::vector<uint16_t> surface = surfaceNormals(mesh);
  for (size_t v = 0; v < surface.size(); ++v) mesh.vertex_attributes[v].normal = surface[v];
  draco_stream::Cursor list(others);
  uint64_t vertex = 0;
  while (!list.isAtEnd()) {
    const uint32_t gap_and_far = list.varint();
    vertex += gap_and_far >> 1;
    if (vertex >= surface.size()) refuse("it lists a normal of a vertex that it does not have");
    const uint8_t first = list.u8();
    const glm::ivec2 code =
        (gap_and_far & 1) != 0 ? glm::ivec2(first, list.u8())
                               : fromCode(surface[vertex]) + glm::ivec2(first & 15, first >> 4) - kNibbleBias;
    if (glm::any(glm::lessThan(code, glm::ivec2(0))) || glm::any(glm::greaterThan(code, glm::ivec2(254))))
      refuse("a normal is off the octahedron");
    mesh.vertex_attributes[vertex++].normal = static_cast<uint16_t>(code.x | code.y << 8);
  }
}

uint16_t cheapNormal(uint16_t wanted, glm::i64vec3 sum) noexcept {
  const glm::ivec2 code(wanted & 255, wanted >> 8), from = predicted(sum), off = code - from;
  if (std::max(std::abs(off.x), std::abs(off.y)) > kFar) return wanted;
  const glm::ivec2 cheap = from + glm::ivec2(roundedToSteps(off.x), roundedToSteps(off.y));
  // On the edges of the octahedron's square, each direction has two codes.
  const bool is_at_edge = std::min(cheap.x, cheap.y) < 1 || std::max(cheap.x, cheap.y) >= kEnd;
  return is_at_edge ? wanted : static_cast<uint16_t>(cheap.x | cheap.y << 8);
}

}  // namespace lode
