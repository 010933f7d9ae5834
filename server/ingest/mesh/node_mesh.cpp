#include "server/ingest/mesh/node_mesh.h"

#include <limits>

namespace lode::ingest {

std::vector<uint32_t> sourcesOf(const SimplifiedMesh& simplified, const NodeMesh& input) {
  std::vector<uint32_t> sources(simplified.mesh.positions.size(), kVanished);
  std::vector<float> nearest(sources.size(), std::numeric_limits<float>::infinity());
  for (uint32_t i = 0; i < simplified.remap.size(); ++i) {
    const uint32_t place = simplified.remap[i];
    if (place == kVanished) continue;
    const glm::vec3 away = glm::vec3(unpackPosition(input.positions[i])) -
                           glm::vec3(unpackPosition(simplified.mesh.positions[place]));
    const float squared = glm::dot(away, away);
    if (squared >= nearest[place]) continue;
    nearest[place] = squared;
    sources[place] = i;
  }
  return sources;
}

}  // namespace lode::ingest
