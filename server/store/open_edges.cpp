#include "server/store/open_edges.h"

#include <algorithm>
#include <tuple>

namespace lode::store {
namespace {

/// Sorts and drops edges in pairs; one that is left keeps the largest error of those it stood for.
void cancelPairs(std::vector<OpenEdge>& edges) {
  std::sort(edges.begin(), edges.end(),
            [](const OpenEdge& x, const OpenEdge& y) { return std::tie(x.a, x.b) < std::tie(y.a, y.b); });
  size_t kept = 0;
  for (size_t i = 0; i < edges.size();) {
    OpenEdge edge = edges[i];
    size_t end = i + 1;
    for (; end < edges.size() && edges[end].a == edge.a && edges[end].b == edge.b; ++end)
      edge.error_model = std::max(edge.error_model, edges[end].error_model);
    if ((end - i) % 2 == 1) edges[kept++] = edge;
    i = end;
  }
  edges.resize(kept);
}

}  // namespace

void OpenEdges::add(const Mesh& mesh, float error_model) {
  std::vector<OpenEdge> own;
  own.reserve(mesh.triangles.size() * 3);
  const auto addEdge = [&](uint32_t from, uint32_t to) {
    const auto [a, b] = std::minmax(mesh.positions[from], mesh.positions[to]);
    if (a != b) own.push_back({a, b, error_model});
  };
  for (const glm::u32vec3& t : mesh.triangles) {
    addEdge(t.x, t.y);
    addEdge(t.y, t.z);
    addEdge(t.z, t.x);
  }
  cancelPairs(own);
  pending_.insert(pending_.end(), own.begin(), own.end());
  if (pending_.size() < cancel_at_) return;
  cancelPairs(pending_);
  cancel_at_ = std::max<size_t>(1u << 16, 2 * pending_.size());
}

const std::vector<OpenEdge>& OpenEdges::edges() {
  cancelPairs(pending_);
  return pending_;
}

}  // namespace lode::store
