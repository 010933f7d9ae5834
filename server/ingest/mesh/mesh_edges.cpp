#include "server/ingest/mesh/mesh_edges.h"

namespace lode::ingest {

std::vector<glm::u32vec2> openEdges(const NodeMesh& mesh) {
  std::vector<glm::u32vec2> open;
  forEachEdge(mesh, [&](uint32_t lower, uint32_t upper, uint32_t uses) {
    if (uses % 2 == 1) open.emplace_back(lower, upper);
  });
  std::sort(open.begin(), open.end(), isBefore);
  return open;
}

std::vector<uint32_t> findBorder(const NodeMesh& mesh) {
  std::vector<bool> is_border(mesh.positions.size());
  forEachEdge(mesh, [&](uint32_t lower, uint32_t upper, uint32_t uses) {
    if (uses != 2) is_border[lower] = is_border[upper] = true;
  });
  std::vector<uint32_t> border;
  for (uint32_t position = 0; position < is_border.size(); ++position)
    if (is_border[position]) border.push_back(position);
  return border;
}

}  // namespace lode::ingest
