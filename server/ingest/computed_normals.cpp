#include "server/ingest/computed_normals.h"

#include <vector>

#include "common/octahedral.h"

namespace lode::ingest {

namespace {

/// A normal a position; wedges of one position share it.
std::vector<uint16_t> normalsOf(const NodeMesh& mesh) {
  std::vector<uint16_t> normals(mesh.positions.size());
  for (size_t wedge = 0; wedge < mesh.wedge_position.size(); ++wedge)
    normals[mesh.wedge_position[wedge]] = mesh.wedge_attributes[wedge].normal;
  return normals;
}

}  // namespace

NodeMesh withoutComputedNormals(NodeMesh mesh) {
  if (!mesh.attributes.has(AttributeSet::kComputedNormal)) return mesh;
  mesh.attributes.bits &= static_cast<uint8_t>(~(AttributeSet::kNormal | AttributeSet::kComputedNormal));
  if (mesh.attributes.bits == 0) mesh.wedge_attributes.clear();
  for (VertexAttributes& attributes : mesh.wedge_attributes) attributes.normal = 0;
  return mesh;
}

void giveComputedNormals(SimplifiedMesh& rung, const NodeMesh& mesh, std::span<const uint32_t> sources) {
  constexpr float kShortest = 1e-3f;
  if (!mesh.attributes.has(AttributeSet::kComputedNormal)) return;
  const std::vector<uint16_t> given = normalsOf(mesh);
  std::vector<glm::vec3> sums(sources.size(), glm::vec3(0));
  for (size_t i = 0; i < given.size(); ++i)
    if (rung.became[i] != kVanished) sums[rung.became[i]] += decodeOctahedral(given[i]);
  std::vector<uint16_t> normals(sources.size());
  for (size_t i = 0; i < sources.size(); ++i) {
    const bool stays = rung.mesh.positions[i] == mesh.positions[sources[i]];
    normals[i] = stays || glm::length(sums[i]) <= kShortest ? given[sources[i]] : encodeOctahedral(sums[i]);
  }
  rung.mesh.attributes = mesh.attributes;
  rung.mesh.wedge_attributes.resize(rung.mesh.wedge_position.size());
  for (size_t wedge = 0; wedge < rung.mesh.wedge_position.size(); ++wedge)
    rung.mesh.wedge_attributes[wedge].normal = normals[rung.mesh.wedge_position[wedge]];
}

}  // namespace lode::ingest
