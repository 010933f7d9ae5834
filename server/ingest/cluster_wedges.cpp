#include "server/ingest/cluster_wedges.h"

#include <numeric>

namespace lode::ingest {

ClusterWedges::ClusterWedges(const CollapseMesh& mesh, const ClusterTree& tree)
    : first_(tree.cells().size() + 1), root_(mesh.wedges.size()) {
  reset();
  if (!mesh.hasWedges()) return;
  const auto forEachLink = [&](auto&& visit) {
    for (uint32_t c = 0; c < mesh.corner_position.size(); ++c) {
      if ((c & 3) == 3) continue;
      const uint32_t next = CollapseMesh::next(c);
      const uint32_t cell = tree.common(mesh.at(c), mesh.at(next));
      if (cell != ClusterTree::kNone) visit(cell, Link{mesh.corner_wedge[c], mesh.corner_wedge[next]});
    }
  };
  forEachLink([&](uint32_t cell, Link) { ++first_[cell + 1]; });
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  links_.resize(first_.back());
  std::vector<uint32_t> end(first_.begin(), first_.end() - 1);
  forEachLink([&](uint32_t cell, Link link) { links_[end[cell]++] = link; });
}

uint32_t ClusterWedges::find(uint32_t wedge) noexcept {
  while (root_[wedge] != wedge) {
    root_[wedge] = root_[root_[wedge]];
    wedge = root_[wedge];
  }
  return wedge;
}

void ClusterWedges::reset() { std::iota(root_.begin(), root_.end(), 0u); }

}  // namespace lode::ingest
