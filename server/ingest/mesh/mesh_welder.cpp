#include "server/ingest/mesh/mesh_welder.h"

#include <algorithm>

namespace lode::ingest {

void MeshWelder::begin(AttributeSet attributes, size_t expected_positions, size_t expected_triangles) {
  mesh_ = {};
  mesh_.attributes = attributes;
  mesh_.triangles.reserve(expected_triangles);
  table_.reset(expected_positions);
  first_wedge_.clear();
  next_wedge_.clear();
}

uint32_t MeshWelder::addCorner(PositionCode code, uint8_t lca_depth, const VertexAttributes& attributes) {
  const auto new_position = static_cast<uint32_t>(mesh_.positions.size());
  const uint32_t position = table_.findOrAdd(code.value, new_position);
  if (position == new_position) {
    mesh_.positions.push_back(code);
    mesh_.lca_depth.push_back(lca_depth);
    first_wedge_.push_back(NumberTable::kAbsent);
  } else {
    mesh_.lca_depth[position] = std::min(mesh_.lca_depth[position], lca_depth);
  }
  for (uint32_t w = first_wedge_[position]; w != NumberTable::kAbsent; w = next_wedge_[w]) {
    if (mesh_.wedge_attributes.empty() || mesh_.wedge_attributes[w] == attributes) return w;
  }
  const auto wedge = static_cast<uint32_t>(mesh_.wedge_position.size());
  mesh_.wedge_position.push_back(position);
  if (mesh_.attributes.bits != 0) mesh_.wedge_attributes.push_back(attributes);
  next_wedge_.push_back(first_wedge_[position]);
  first_wedge_[position] = wedge;
  return wedge;
}

void MeshWelder::addTriangle(glm::u32vec3 wedges) {
  const uint32_t a = mesh_.wedge_position[wedges.x], b = mesh_.wedge_position[wedges.y],
                 c = mesh_.wedge_position[wedges.z];
  if (a != b && b != c && c != a) mesh_.triangles.push_back(wedges);
}

NodeMesh mergeMeshes(std::span<const NodeMesh> meshes, std::vector<std::vector<uint32_t>>& remap) {
  size_t positions = 0, triangles = 0;
  AttributeSet attributes;
  for (const NodeMesh& mesh : meshes) {
    positions += mesh.positions.size();
    triangles += mesh.triangles.size();
    attributes = mesh.attributes;
  }
  MeshWelder welder;
  welder.begin(attributes, positions, triangles);
  remap.clear();
  std::vector<uint32_t> numbers;
  for (const NodeMesh& mesh : meshes) {
    remap.emplace_back(mesh.positions.size());
    numbers.resize(mesh.wedge_position.size());
    for (size_t w = 0; w < numbers.size(); ++w) {
      const uint32_t position = mesh.wedge_position[w];
      numbers[w] =
          welder.addCorner(mesh.positions[position], mesh.lca_depth[position],
                           mesh.wedge_attributes.empty() ? VertexAttributes{} : mesh.wedge_attributes[w]);
      remap.back()[position] = welder.positionOf(numbers[w]);
    }
    for (const glm::u32vec3& t : mesh.triangles) {
      welder.addTriangle({numbers[t.x], numbers[t.y], numbers[t.z]});
    }
  }
  return welder.finish();
}

void joinEqualWedges(NodeMesh& mesh) {
  std::vector<uint32_t> last(mesh.positions.size(), NumberTable::kAbsent);  // last wedge of each position
  std::vector<uint32_t> before;  // for each wedge, the previous wedge of the same position
  std::vector<uint32_t> number(mesh.wedge_position.size());
  for (size_t wedge = 0; wedge < number.size(); ++wedge) {
    const uint32_t position = mesh.wedge_position[wedge];
    const VertexAttributes attributes = mesh.wedge_attributes[wedge];
    uint32_t found = last[position];
    while (found != NumberTable::kAbsent && mesh.wedge_attributes[found] != attributes) found = before[found];
    if (found == NumberTable::kAbsent) {
      found = static_cast<uint32_t>(before.size());
      before.push_back(last[position]);
      last[position] = found;
      mesh.wedge_position[found] = position;
      mesh.wedge_attributes[found] = attributes;
    }
    number[wedge] = found;
  }
  mesh.wedge_position.resize(before.size());
  mesh.wedge_attributes.resize(before.size());
  for (glm::u32vec3& t : mesh.triangles) t = {number[t.x], number[t.y], number[t.z]};
}

Mesh toMesh(const NodeMesh& mesh) {
  Mesh result;
  result.attributes = mesh.attributes;
  result.positions.reserve(mesh.wedge_position.size());
  for (const uint32_t position : mesh.wedge_position) result.positions.push_back(mesh.positions[position]);
  result.vertex_attributes = mesh.wedge_attributes;
  result.triangles = mesh.triangles;
  return result;
}

}  // namespace lode::ingest
