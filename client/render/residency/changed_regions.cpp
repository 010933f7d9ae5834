#include "client/render/residency/changed_regions.h"

#include <algorithm>

namespace lode::render {
namespace {

struct Change {
  NodeKey node;
  bool arrives = false;
  uint32_t index = 0;
};

}  // namespace

std::vector<ChangedRegion> changedRegions(std::span<const NodeKey> leaving,
                                          std::span<const NodeKey> arriving) {
  std::vector<Change> changes;
  changes.reserve(leaving.size() + arriving.size());
  for (uint32_t i = 0; i < leaving.size(); ++i) changes.push_back({leaving[i], false, i});
  for (uint32_t i = 0; i < arriving.size(); ++i) changes.push_back({arriving[i], true, i});
  std::ranges::stable_sort(changes, {}, [](const Change& change) { return depthFirst(change.node); });
  std::vector<ChangedRegion> regions;
  for (const Change& change : changes) {
    if (regions.empty() || !regions.back().node.contains(change.node))
      regions.push_back({change.node, {}, {}});
    ChangedRegion& region = regions.back();
    (change.arrives ? region.arriving : region.leaving).push_back(change.index);
  }
  return regions;
}

}  // namespace lode::render
