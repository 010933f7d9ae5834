#include "client/core/lod/view_cuts.h"

#include <algorithm>
#include <tuple>
#include <unordered_set>

#include "client/core/cache/drawn_bytes.h"
#include "client/core/lod/shown_parts.h"

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

std::vector<Request> mergeRequests(std::span<const std::vector<Request>> requests) {
  if (requests.size() == 1) return requests.front();
  std::vector<Request> merged;
  for (const std::vector<Request>& of_view : requests)
    merged.insert(merged.end(), of_view.begin(), of_view.end());
  std::sort(merged.begin(), merged.end(), [](const Request& a, const Request& b) {
    return std::tie(a.use, a.request_class, b.priority_px, a.is_stand_in) <
           std::tie(b.use, b.request_class, a.priority_px, b.is_stand_in);
  });
  const auto is_same = [](const Request& a, const Request& b) { return a.use == b.use; };
  merged.erase(std::unique(merged.begin(), merged.end(), is_same), merged.end());
  std::sort(merged.begin(), merged.end(), [](const Request& a, const Request& b) {
    return std::tie(a.request_class, b.priority_px, a.use) < std::tie(b.request_class, a.priority_px, b.use);
  });
  return merged;
}

}  // namespace lode::core
