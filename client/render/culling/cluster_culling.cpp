#include "client/render/culling/cluster_culling.h"

#include <algorithm>

namespace lode::render {

uint32_t SeenCluster::triangles() const noexcept {
  return std::min(kClusterTriangles, part.item->index_count / 3 - firstTriangle());
}

std::vector<bool>::reference SeenCluster::hidden(size_t instance) const {
  auto& instances = part.item->clusters->hidden;
  if (instances.size() <= instance) instances.resize(instance + 1);
  instances[instance].resize(part.item->clusters->boxes.size());
  return instances[instance][number];
}

bool isInPicture(const SeenPart& part, const core::ViewFrustum& frustum, double lattice_step) {
  return frustum.test(core::toModelBox(part.item->box, lattice_step)) != core::Visibility::kOutside;
}

size_t addSeenClusters(const SeenPart& part, const core::ViewFrustum& frustum, double lattice_step,
                       std::vector<SeenCluster>& seen) {
  const core::Visibility whole = frustum.test(core::toModelBox(part.item->box, lattice_step));
  if (whole == core::Visibility::kOutside) return 0;
  const size_t before = seen.size();
  const std::vector<LatticeBox>& boxes = part.item->clusters->boxes;
  for (uint32_t number = 0; number < boxes.size(); ++number) {
    if (whole == core::Visibility::kPartial &&
        frustum.test(core::toModelBox(boxes[number], lattice_step)) == core::Visibility::kOutside)
      continue;
    seen.push_back({part, number});
  }
  return seen.size() - before;
}

void DrawList::clear(size_t pages) {
  by_page.resize(pages);
  for (auto& page : by_page) page.clear();
}

void DrawList::add(const SeenCluster& cluster) {
  const DrawItem& item = *cluster.part.item;
  std::vector<DrawCommand>& page = by_page[item.page];
  const uint32_t index = item.first_index + 3 * cluster.firstTriangle(), count = 3 * cluster.triangles();
  if (!page.empty() && page.back().base_instance == cluster.part.state &&
      page.back().first_index + page.back().count == index)
    page.back().count += count;
  else
    page.push_back({count, 1, index, static_cast<int32_t>(item.base_vertex), cluster.part.state});
}

bool DrawList::empty() const noexcept {
  return std::ranges::all_of(by_page, &std::vector<DrawCommand>::empty);
}

}  // namespace lode::render
