#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "common/node_key.h"

namespace lode::render {

/// Orders nodes depth first: one before all that is below it, and that before anything else.
constexpr std::pair<uint64_t, int> depthFirst(NodeKey node) noexcept {
  return {node.value << 3 * (kMaxDepth - node.depth()), node.depth()};
}

/// Where what covers a model changes hands: what leaves and what arrives there covers the same, since no
/// other part reaches below the region's node.
struct ChangedRegion {
  NodeKey node;
  std::vector<uint32_t> leaving, arriving;  ///< indices into what changedRegions() was given

  bool operator==(const ChangedRegion&) const = default;
};

/// Matches the nodes that only the old cover has with those that only the new one has.
/// @return regions depth first; each has the shallowest of its nodes.
std::vector<ChangedRegion> changedRegions(std::span<const NodeKey> leaving,
                                          std::span<const NodeKey> arriving);

}  // namespace lode::render
