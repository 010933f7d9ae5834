#include "client/core/lod/cut.h"

#include <algorithm>
#include <unordered_set>

#include "client/core/cache/mesh_cache.h"
#include "client/core/lod/part_error.h"
#include "client/core/view/view.h"

namespace lode::core {

/// Iterates over the fallbacks and parts from last to first, so that each fallback is tested before the
/// fallbacks below it.
std::vector<uint32_t> shownParts(const Cut& cut, const View& view) {
  const ViewFrustum frustum(view, 1);
  const auto isSeen = [&](const LeftOut& place) { return frustum.test(place.box) != Visibility::kOutside; };
  std::vector<uint32_t> shown;
  shown.reserve(partCount(cut));
  // All parts from this index to the end are already selected or replaced.
  auto begin = static_cast<uint32_t>(cut.parts.size());
  const auto showDownTo = [&](uint32_t part) {
    while (begin > part) shown.push_back(--begin);
  };
  for (auto number = static_cast<uint32_t>(cut.fallbacks.size()); number > 0;) {
    const Fallback& fallback = cut.fallbacks[--number];
    const auto places = cut.left_out.begin();
    if (std::none_of(places + fallback.first_left_out, places + fallback.end_left_out, isSeen)) continue;
    showDownTo(fallback.end_part);
    shown.push_back(static_cast<uint32_t>(cut.parts.size()) + number);
    begin = fallback.first_part;
    number = fallback.first_nested;
  }
  showDownTo(0);
  std::reverse(shown.begin(), shown.end());
  return shown;
}

float shownErrorPx(const Cut& cut, std::span<const uint32_t> shown, const View& view) {
  const ViewFrustum frustum(view, 1);
  float largest_px = 0;
  for (const uint32_t number : shown)
    largest_px = std::max(largest_px, partErrorPx(partOf(cut, number), cut.lattice_step, frustum));
  return largest_px;
}

size_t countHoles(const Cut& cut, std::span<const uint32_t> shown, const View& view) {
  if (cut.left_out.empty()) return 0;
  const ViewFrustum frustum(view, 1);
  std::unordered_set<uint64_t> drawn;
  for (const uint32_t number : shown) drawn.insert(partOf(cut, number).node.value);
  return static_cast<size_t>(std::ranges::count_if(cut.left_out, [&](const LeftOut& place) {
    if (frustum.test(place.box) == Visibility::kOutside) return false;
    NodeKey above = place.node;
    while (above != kRootKey && !drawn.contains(above.value)) above = above.parent();
    return !drawn.contains(above.value);
  }));
}

std::shared_ptr<Cut> gatherMeshes(std::span<const std::shared_ptr<const Cut>> cuts) {
  auto all = std::make_shared<Cut>();
  all->view = cuts.front()->view;
  all->threshold_px = cuts.front()->threshold_px;
  all->build = cuts.front()->build;
  all->lattice_step = cuts.front()->lattice_step;
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

}  // namespace lode::core
