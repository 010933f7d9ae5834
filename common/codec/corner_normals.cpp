#include "common/codec/corner_normals.h"

#include <algorithm>
#include <bit>

namespace lode {
namespace {

/// Hashes a position so that neighbouring lattice points get values far apart. Source: Appleby, MurmurHash3
/// (first half of the finalizer).
size_t hashOf(PositionCode position) noexcept {
  const uint64_t mixed = (position.value ^ position.value >> 33) * 0xff51afd7ed558ccdULL;
  return mixed ^ mixed >> 33;
}

}  // namespace

CornerNormals::CornerNormals(const Mesh& mesh) : positions_(std::bit_ceil(2 * mesh.positions.size() + 1)) {
  for (uint32_t v = 0; v < mesh.positions.size(); ++v) {
    OfPosition& place = positions_[placeOf(mesh.positions[v])];
    const uint16_t normal = mesh.vertex_attributes[v].normal;
    if (place.is_taken)
      place.has_several |= place.normal != normal;
    else
      place = {mesh.positions[v], normal, true};
  }
  for (const glm::u32vec3 t : mesh.triangles)
    for (int k = 0; k < 3; ++k) {
      if (at(mesh.positions[t[k]])) continue;
      corners_.push_back(cornerOf(mesh, t, k));
      corners_.back().normal = mesh.vertex_attributes[t[k]].normal;
    }
  std::sort(corners_.begin(), corners_.end());
  corners_.erase(std::unique(corners_.begin(), corners_.end()), corners_.end());
}

CornerNormals::OfCorner CornerNormals::cornerOf(const Mesh& mesh, glm::u32vec3 triangle, int corner) {
  return {mesh.positions[triangle[corner]], mesh.positions[triangle[(corner + 1) % 3]],
          mesh.positions[triangle[(corner + 2) % 3]], 0};
}

size_t CornerNormals::placeOf(PositionCode position) const noexcept {
  size_t at = hashOf(position) & (positions_.size() - 1);
  while (positions_[at].is_taken && positions_[at].position != position)
    at = (at + 1) & (positions_.size() - 1);
  return at;
}

std::optional<uint16_t> CornerNormals::at(PositionCode position) const {
  const OfPosition& found = positions_[placeOf(position)];
  return found.is_taken && !found.has_several ? std::optional(found.normal) : std::nullopt;
}

std::optional<uint16_t> CornerNormals::at(const OfCorner& corner) const {
  const auto is_of = [&](const OfCorner& other) {
    return other.position == corner.position && other.next == corner.next && other.last == corner.last;
  };
  const auto found = std::lower_bound(corners_.begin(), corners_.end(), corner);
  if (found == corners_.end() || !is_of(*found)) return std::nullopt;
  return found + 1 == corners_.end() || !is_of(found[1]) ? std::optional(found->normal) : std::nullopt;
}

std::optional<std::vector<uint16_t>> CornerNormals::ofVertices(const Mesh& mesh) const {
  std::vector<uint16_t> normals(mesh.positions.size());
  std::vector<bool> told(normals.size());
  for (uint32_t v = 0; v < normals.size(); ++v)
    if (const std::optional<uint16_t> only = at(mesh.positions[v])) {
      normals[v] = *only;
      told[v] = true;
    }
  for (const glm::u32vec3 t : mesh.triangles)
    for (int k = 0; k < 3; ++k) {
      if (told[t[k]]) continue;
      const std::optional<uint16_t> normal = at(cornerOf(mesh, t, k));
      if (!normal) return std::nullopt;
      normals[t[k]] = *normal;
      told[t[k]] = true;
    }
  return normals;
}

}  // namespace lode
