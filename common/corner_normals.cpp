#include "common/corner_normals.h"

#include <algorithm>

namespace lode {
namespace {

template <typename T>
void sortOnce(std::vector<T>& items) {
  std::sort(items.begin(), items.end());
  items.erase(std::unique(items.begin(), items.end()), items.end());
}

}  // namespace

CornerNormals::CornerNormals(const Mesh& mesh) {
  positions_.reserve(mesh.positions.size());
  for (uint32_t v = 0; v < mesh.positions.size(); ++v)
    positions_.push_back({mesh.positions[v], mesh.vertex_attributes[v].normal});
  sortOnce(positions_);
  for (const glm::u32vec3 t : mesh.triangles)
    for (int k = 0; k < 3; ++k) {
      if (at(mesh.positions[t[k]])) continue;
      corners_.push_back(cornerOf(mesh, t, k));
      corners_.back().normal = mesh.vertex_attributes[t[k]].normal;
    }
  sortOnce(corners_);
}

CornerNormals::OfCorner CornerNormals::cornerOf(const Mesh& mesh, glm::u32vec3 triangle, int corner) {
  return {mesh.positions[triangle[corner]], mesh.positions[triangle[(corner + 1) % 3]],
          mesh.positions[triangle[(corner + 2) % 3]], 0};
}

std::optional<uint16_t> CornerNormals::at(PositionCode position) const {
  const auto found = std::lower_bound(positions_.begin(), positions_.end(), OfPosition{position, 0});
  const bool is_only = found + 1 == positions_.end() || found[1].position != position;
  return is_only ? std::optional(found->normal) : std::nullopt;
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
