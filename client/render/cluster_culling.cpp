#include "client/render/cluster_culling.h"

#include <algorithm>

namespace lode::render {

uint32_t SeenCluster::triangles() const noexcept {
  return std::min(kClusterTriangles, part.item->index_count / 3 - firstTriangle());
}

std::vector<bool>::reference SeenCluster::hidden(size_t place) const {
  auto& places = part.item->clusters->hidden;
  if (places.size() <= place) places.resize(place + 1);
  places[place].resize(part.item->clusters->boxes.size());
  return places[place][number];
}

bool isInPicture(const SeenPart& part, const core::Sight& sight, double lattice_step) {
  return sight.see(core::toModelBox(part.item->box, lattice_step)) != core::Seen::kNot;
}

size_t addSeenClusters(const SeenPart& part, const core::Sight& sight, double lattice_step,
                       std::vector<SeenCluster>& seen) {
  const core::Seen whole = sight.see(core::toModelBox(part.item->box, lattice_step));
  if (whole == core::Seen::kNot) return 0;
  const size_t before = seen.size();
  const std::vector<LatticeBox>& boxes = part.item->clusters->boxes;
  for (uint32_t number = 0; number < boxes.size(); ++number) {
    if (whole == core::Seen::kPartly &&
        sight.see(core::toModelBox(boxes[number], lattice_step)) == core::Seen::kNot)
      continue;
    seen.push_back({part, number});
  }
  return seen.size() - before;
}

}  // namespace lode::render
