#include "server/ingest/measure/rung_input.h"

#include <utility>

#include "server/ingest/mesh/mesh_edges.h"

namespace lode::ingest {

RungInput::RungInput(NodeMesh mesh, int depth, std::vector<Range> original)
    : mesh_(std::move(mesh)), walk_(mesh_), original_(std::move(original)), rims_(openEdges(mesh_)) {
  const auto is_locked = [&](uint32_t position) { return mesh_.lca_depth[position] < depth; };
  std::erase_if(rims_, [&](glm::u32vec2 edge) { return is_locked(edge.x) && is_locked(edge.y); });
}

bool RungInput::isOriginal() const noexcept {
  size_t original = 0;
  for (const Range& range : original_) original += range.end - range.begin;
  return original == mesh_.triangles.size();
}

const TriangleGrid& RungInput::grid() const {
  std::call_once(grid_made_, [this] { grid_.emplace(mesh_); });
  return *grid_;
}

}  // namespace lode::ingest
