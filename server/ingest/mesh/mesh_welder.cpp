#include "server/ingest/mesh/mesh_welder.h"

#include <algorithm>

namespace lode::ingest {

void MeshWelder::begin(AttributeSet attributes, size_t expected_positions, size_t expected_triangles) {
  mesh_ = {};
  mesh_.attributes = attributes;
  mesh_.triangles.reserve(expected_triangles);
  table_.reset(expected_positions);
  wedges_.reset(0);
}

uint32_t MeshWelder::addCorner(PositionCode code, uint8_t lca_depth, const VertexAttributes& attributes) {
  const auto new_position = static_cast<uint32_t>(mesh_.positions.size());
  const uint32_t position = table_.findOrAdd(code.value, new_position);
  if (position == new_position) {
    mesh_.positions.push_back(code);
    mesh_.lca_depth.push_back(lca_depth);
    wedges_.addPosition();
  } else {
    mesh_.lca_depth[position] = std::min(mesh_.lca_depth[position], lca_depth);
  }
  const bool has_attributes = mesh_.attributes.bits != 0;
  const uint32_t known =
      has_attributes ? wedges_.find(position, attributes, mesh_.wedge_attributes) : wedges_.any(position);
  if (known != WedgeFinder::kNone) return known;
  const auto wedge = static_cast<uint32_t>(mesh_.wedge_position.size());
  mesh_.wedge_position.push_back(position);
  if (has_attributes) mesh_.wedge_attributes.push_back(attributes);
  wedges_.add(position, wedge, mesh_.wedge_attributes);
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
  WedgeFinder known;
  known.reset(mesh.positions.size());
  uint32_t count = 0;
  std::vector<uint32_t> number(mesh.wedge_position.size());
  for (size_t wedge = 0; wedge < number.size(); ++wedge) {
    const uint32_t position = mesh.wedge_position[wedge];
    const VertexAttributes attributes = mesh.wedge_attributes[wedge];
    number[wedge] = known.find(position, attributes, mesh.wedge_attributes);
    if (number[wedge] != WedgeFinder::kNone) continue;
    number[wedge] = count++;
    mesh.wedge_position[number[wedge]] = position;
    mesh.wedge_attributes[number[wedge]] = attributes;
    known.add(position, number[wedge], mesh.wedge_attributes);
  }
  mesh.wedge_position.resize(count);
  mesh.wedge_attributes.resize(count);
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
