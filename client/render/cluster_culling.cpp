#include "client/render/cluster_culling.h"

#include <algorithm>

namespace lode::render {

uint32_t SeenCluster::triangles() const noexcept {
  const uint32_t all = item->index_count / 3;
  return item->clusters->boxes.size() == 1 ? all : std::min(kClusterTriangles, all - firstTriangle());
}

std::vector<bool>::reference SeenCluster::hidden(size_t place) const {
  auto& places = item->clusters->hidden;
  if (places.size() <= place) places.resize(place + 1);
  places[place].resize(item->clusters->boxes.size());
  return places[place][number];
}

size_t addSeenClusters(const SeenCluster& like, const core::Sight& sight, double lattice_step,
                       std::vector<SeenCluster>& seen) {
  const core::Seen whole = sight.see(core::toModelBox(like.item->box, lattice_step));
  if (whole == core::Seen::kNot) return 0;
  const size_t before = seen.size();
  const std::vector<LatticeBox>& boxes = like.item->clusters->boxes;
  for (uint32_t number = 0; number < boxes.size(); ++number) {
    if (whole == core::Seen::kPartly &&
        sight.see(core::toModelBox(boxes[number], lattice_step)) == core::Seen::kNot)
      continue;
    seen.push_back(like);
    seen.back().number = number;
  }
  return seen.size() - before;
}

}  // namespace lode::render
