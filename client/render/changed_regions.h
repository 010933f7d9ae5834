#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/node_key.h"

namespace lode::render {

/// Where what covers a model changes hands: what leaves and what arrives there covers the same, since no
/// other part reaches below the region's node.
struct ChangedRegion {
  NodeKey node;
  std::vector<uint32_t> leaving, arriving;  ///< indices into what changedRegions() was given

  bool operator==(const ChangedRegion&) const = default;
};

/// Matches the nodes that only the old cover has with those that only the new one has. A cover has no node
/// below another of its own.
/// @return regions depth first; each has the shallowest of its nodes.
std::vector<ChangedRegion> changedRegions(std::span<const NodeKey> leaving,
                                          std::span<const NodeKey> arriving);

}  // namespace lode::render
