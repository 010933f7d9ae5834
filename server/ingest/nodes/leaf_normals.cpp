#include "server/ingest/nodes/leaf_normals.h"

#include <algorithm>
#include <vector>

#include "common/codec/surface_normals.h"

namespace lode::ingest {
namespace {

constexpr uint32_t kNoWedge = ~0u;

std::vector<uint16_t> normalsOfFans(const NodeMesh& mesh, const NormalFans& fans,
                                    std::span<const BorderVertex> border) {
  std::vector<uint16_t> normals;
  normals.reserve(fans.sums.size());
  for (const glm::i64vec3& sum : fans.sums) normals.push_back(normalOf(sum));
  for (size_t p = 0; p < mesh.positions.size() && !border.empty(); ++p) {
    for (const BorderVertex& shared : sharedAt(border, mesh.positions[p]))
      normals[fans.first[p] + shared.fan] = shared.normal;
  }
  return normals;
}

}  // namespace

void giveLeafNormals(NodeMesh& mesh, std::span<const BorderVertex> border, const CreaseAngle& crease) {
  const NormalFans fans = findFans(mesh, crease);
  const std::vector<uint16_t> normals = normalsOfFans(mesh, fans, border);
  mesh.wedge_attributes.resize(mesh.wedge_position.size());
  std::vector<bool> is_given(mesh.wedge_position.size());
  std::vector<uint32_t> next(mesh.wedge_position.size(), kNoWedge);  // the same wedge with another normal
  for (size_t c = 0; c < fans.of_corner.size(); ++c) {
    const uint16_t normal = normals[fans.of_corner[c]];
    uint32_t& wedge = mesh.triangles[c / 3][static_cast<int>(c % 3)];
    if (!is_given[wedge]) {
      is_given[wedge] = true;
      mesh.wedge_attributes[wedge].normal = normal;
      continue;
    }
    while (mesh.wedge_attributes[wedge].normal != normal && next[wedge] != kNoWedge) wedge = next[wedge];
    if (mesh.wedge_attributes[wedge].normal == normal) continue;
    const auto added = static_cast<uint32_t>(mesh.wedge_position.size());
    VertexAttributes attributes = mesh.wedge_attributes[wedge];
    attributes.normal = normal;
    mesh.wedge_attributes.push_back(attributes);
    mesh.wedge_position.push_back(mesh.wedge_position[wedge]);
    next.push_back(kNoWedge);
    next[wedge] = added;
    wedge = added;
  }
}

}  // namespace lode::ingest
