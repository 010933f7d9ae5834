#include "server/store/open_edges.h"

#include <algorithm>

namespace lode::store {
namespace {

/// Sorts edges and removes equal edges in pairs.
void cancelPairs(std::vector<OpenEdge>& edges) {
  std::sort(edges.begin(), edges.end());
  size_t kept = 0;
  for (size_t i = 0; i < edges.size();) {
    size_t end = i + 1;
    while (end < edges.size() && edges[end] == edges[i]) ++end;
    if ((end - i) % 2 == 1) edges[kept++] = edges[i];
    i = end;
  }
  edges.resize(kept);
}

}  // namespace

void OpenEdges::add(const Mesh& mesh) {
  std::vector<OpenEdge> own;
  own.reserve(mesh.triangles.size() * 3);
  const auto addEdge = [&](uint32_t from, uint32_t to) {
    const auto [a, b] = std::minmax(mesh.positions[from], mesh.positions[to]);
    if (a != b) own.push_back({a, b});
  };
  for (const glm::u32vec3& t : mesh.triangles) {
    addEdge(t.x, t.y);
    addEdge(t.y, t.z);
    addEdge(t.z, t.x);
  }
  cancelPairs(own);
  add(own);
}

void OpenEdges::add(std::span<const OpenEdge> open) {
  pending_.insert(pending_.end(), open.begin(), open.end());
  if (pending_.size() < cancel_at_) return;
  cancelPairs(pending_);
  cancel_at_ = std::max<size_t>(1u << 16, 2 * pending_.size());
}

const std::vector<OpenEdge>& OpenEdges::edges() {
  cancelPairs(pending_);
  return pending_;
}

}  // namespace lode::store
