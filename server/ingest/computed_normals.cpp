#include "server/ingest/computed_normals.h"

#include <utility>

#include "common/octahedral.h"

namespace lode::ingest {

bool hasComputedNormalsAlone(const NodeMesh& mesh) noexcept {
  return mesh.attributes.bits == (AttributeSet::kNormal | AttributeSet::kComputedNormal) &&
         mesh.wedge_position.size() == mesh.positions.size();
}

NodeMesh withoutAttributes(NodeMesh mesh) {
  mesh.attributes = {};
  mesh.wedge_attributes.clear();
  return mesh;
}

void giveComputedNormals(SimplifiedMesh& rung, const NodeMesh& mesh, const SurfaceWalk& walk,
                         std::span<const uint32_t> sources) {
  constexpr float kShortest = 1e-3f;
  rung.mesh.attributes = mesh.attributes;
  rung.mesh.wedge_attributes.resize(sources.size());
  for (size_t i = 0; i < sources.size(); ++i) {
    uint16_t& code = rung.mesh.wedge_attributes[i].normal;
    code = mesh.wedge_attributes[sources[i]].normal;
    if (rung.mesh.positions[i] == mesh.positions[sources[i]]) continue;
    const SurfaceWalk::Place place =
        walk.placeOf(glm::vec3(unpackPosition(rung.mesh.positions[i])), sources[i]);
    glm::vec3 sum(0);
    for (int k = 0; k < 3; ++k) {
      const uint32_t corner = mesh.triangles[place.triangle][k];
      sum += place.shares[k] * decodeOctahedral(mesh.wedge_attributes[corner].normal);
    }
    if (glm::length(sum) > kShortest) code = encodeOctahedral(sum);
  }
}

}  // namespace lode::ingest
