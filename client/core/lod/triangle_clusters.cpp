#include "client/core/lod/triangle_clusters.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <utility>

namespace lode::core {
namespace {

/// Bits per axis of a Morton code; the mesh's longest side spans the full range.
constexpr int kPlaceBits = 10;
constexpr int kDigits = 3;  ///< number of radix sort digits of a Morton code; each digit has kPlaceBits bits

/// Returns three times the centroid of a triangle.
glm::uvec3 middleOf(const Mesh& mesh, const glm::u32vec3& triangle) {
  return unpackPosition(mesh.positions[triangle.x]) + unpackPosition(mesh.positions[triangle.y]) +
         unpackPosition(mesh.positions[triangle.z]);
}

/// Inserts two zero bits between the bits of a coordinate.
constexpr uint32_t spread(uint32_t place) noexcept {
  place = (place | place << 16) & 0x030000ff;
  place = (place | place << 8) & 0x0300f00f;
  place = (place | place << 4) & 0x030c30c3;
  return (place | place << 2) & 0x09249249;
}

/// Returns one value per triangle: its Morton code in the upper 32 bits and its index in the lower 32 bits.
std::vector<uint64_t> codesOf(const Mesh& mesh) {
  std::vector<glm::uvec3> middles;
  middles.reserve(mesh.triangles.size());
  glm::uvec3 least(UINT32_MAX), most(0);
  for (const glm::u32vec3& triangle : mesh.triangles) {
    middles.push_back(middleOf(mesh, triangle));
    least = glm::min(least, middles.back());
    most = glm::max(most, middles.back());
  }
  const glm::uvec3 size = most - least;
  const int shift =
      std::max(0, static_cast<int>(std::bit_width(std::max({size.x, size.y, size.z}))) - kPlaceBits);
  std::vector<uint64_t> codes(middles.size());
  for (size_t i = 0; i < middles.size(); ++i) {
    const glm::uvec3 place = (middles[i] - least) >> static_cast<unsigned>(shift);
    const uint64_t code = spread(place.x) | spread(place.y) << 1 | spread(place.z) << 2;
    codes[i] = code << 32 | i;
  }
  return codes;
}

/// Sorts triangles by Morton code, with a stable radix sort.
void sortByCode(std::vector<uint64_t>& codes) {
  std::vector<uint64_t> sorted(codes.size());
  for (int digit = 0; digit < kDigits; ++digit) {
    const int shift = 32 + digit * kPlaceBits;
    const auto digitOf = [shift](uint64_t code) { return code >> shift & ((1u << kPlaceBits) - 1); };
    std::array<uint32_t, 1u << kPlaceBits> ends{};
    for (const uint64_t code : codes) ++ends[digitOf(code)];
    uint32_t before = 0;
    for (uint32_t& end : ends) before += std::exchange(end, before);
    for (const uint64_t code : codes) sorted[ends[digitOf(code)]++] = code;
    codes.swap(sorted);
  }
}

LatticeBox boxOf(const Mesh& mesh, std::span<const glm::u32vec3> triangles) {
  LatticeBox box;
  for (const glm::u32vec3& triangle : triangles)
    for (int corner = 0; corner < 3; ++corner) box.add(unpackPosition(mesh.positions[triangle[corner]]));
  return box;
}

}  // namespace

void clusterTriangles(Mesh& mesh) {
  mesh.cluster_boxes.clear();
  mesh.cluster_boxes.reserve(clusterCount(mesh.triangles.size()));
  if (mesh.triangles.size() > kClusterTriangles) {
    std::vector<uint64_t> codes = codesOf(mesh);
    sortByCode(codes);
    std::vector<glm::u32vec3> ordered(codes.size());
    for (size_t i = 0; i < codes.size(); ++i) ordered[i] = mesh.triangles[static_cast<uint32_t>(codes[i])];
    mesh.triangles = std::move(ordered);
  }
  const std::span<const glm::u32vec3> triangles(mesh.triangles);
  for (size_t first = 0; first < triangles.size(); first += kClusterTriangles) {
    const size_t count = std::min<size_t>(kClusterTriangles, triangles.size() - first);
    mesh.cluster_boxes.push_back(boxOf(mesh, triangles.subspan(first, count)));
  }
}

}  // namespace lode::core
