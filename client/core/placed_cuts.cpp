#include "client/core/placed_cuts.h"

#include <algorithm>
#include <tuple>
#include <unordered_set>

#include "client/core/drawn_bytes.h"
#include "client/core/shown_parts.h"

namespace lode::core {

std::shared_ptr<Cut> gatherMeshes(std::span<const std::shared_ptr<const Cut>> cuts) {
  auto all = std::make_shared<Cut>();
  all->view = cuts.front()->view;
  all->threshold_px = cuts.front()->threshold_px;
  all->build = cuts.front()->build;
  all->converged = true;
  std::unordered_set<const Mesh*> known;
  for (const auto& cut : cuts) {
    for (size_t number = 0; number < partCount(*cut); ++number) {
      const CutPart& part = partOf(*cut, number);
      if (!known.insert(part.mesh.get()).second) continue;
      all->drawn_bytes += drawnBytes(*part.mesh);
      all->parts.push_back(part);
    }
    all->triangles += cut->triangles;
    all->max_error_px = std::max(all->max_error_px, cut->max_error_px);
    all->refinable_px = std::max(all->refinable_px, cut->refinable_px);
    all->converged = all->converged && cut->converged;
  }
  return all;
}

std::vector<Wish> mergeWishes(std::span<const std::vector<Wish>> wishes) {
  if (wishes.size() == 1) return wishes.front();
  std::vector<Wish> merged;
  for (const std::vector<Wish>& of_view : wishes) merged.insert(merged.end(), of_view.begin(), of_view.end());
  std::sort(merged.begin(), merged.end(), [](const Wish& a, const Wish& b) {
    return std::tie(a.use, a.wish_class, b.priority_px, a.is_stand_in) <
           std::tie(b.use, b.wish_class, a.priority_px, b.is_stand_in);
  });
  const auto is_same = [](const Wish& a, const Wish& b) { return a.use == b.use; };
  merged.erase(std::unique(merged.begin(), merged.end(), is_same), merged.end());
  std::sort(merged.begin(), merged.end(), [](const Wish& a, const Wish& b) {
    return std::tie(a.wish_class, b.priority_px, a.use) < std::tie(b.wish_class, a.priority_px, b.use);
  });
  return merged;
}

}  // namespace lode::core
