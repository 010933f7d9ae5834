#include "server/ingest/measure/rung_input.h"

#include <utility>

#include "server/ingest/mesh/mesh_edges.h"

namespace lode::ingest {

RungInput::RungInput(NodeMesh mesh, int depth, std::optional<float> off_steps)
    : mesh_(std::move(mesh)), walk_(mesh_), off_steps_(off_steps), rims_(openEdges(mesh_)) {
  const auto is_locked = [&](uint32_t position) { return mesh_.lca_depth[position] < depth; };
  std::erase_if(rims_, [&](glm::u32vec2 edge) { return is_locked(edge.x) && is_locked(edge.y); });
}

const TriangleTree& RungInput::tree() const {
  std::call_once(tree_made_, [this] { tree_.emplace(mesh_); });
  return *tree_;
}

}  // namespace lode::ingest
