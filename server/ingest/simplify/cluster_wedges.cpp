#include "server/ingest/simplify/cluster_wedges.h"

#include <numeric>

namespace lode::ingest {

ClusterWedges::ClusterWedges(const CollapseMesh& mesh, const ClusterTree& tree)
    : first_(tree.cells().size() + 1), root_(mesh.wedges.size()) {
  reset();
  if (!mesh.hasWedges()) return;
  std::vector<uint32_t> cells(mesh.corner_position.size(), ClusterTree::kNone);  // of the edge from a corner
  for (uint32_t c = 0; c < cells.size(); ++c) {
    if ((c & 3) == 3) continue;
    cells[c] = tree.common(mesh.at(c), mesh.at(CollapseMesh::next(c)));
    if (cells[c] != ClusterTree::kNone) ++first_[cells[c] + 1];
  }
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  links_.resize(first_.back());
  std::vector<uint32_t> end(first_.begin(), first_.end() - 1);
  for (uint32_t c = 0; c < cells.size(); ++c) {
    if (cells[c] == ClusterTree::kNone) continue;
    links_[end[cells[c]]++] = {mesh.corner_wedge[c], mesh.corner_wedge[CollapseMesh::next(c)]};
  }
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
