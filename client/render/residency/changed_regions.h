#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "common/node_key.h"

namespace lode::render {

/// Sort key for depth-first order: a node precedes its descendants, which precede the next node.
constexpr std::pair<uint64_t, int> depthFirst(NodeKey node) noexcept {
  return {node.value << 3 * (kMaxDepth - node.depth()), node.depth()};
}

/// A region of the model whose parts are replaced. The leaving and the arriving parts cover the same region,
/// because all parts below the region's node belong to it.
struct ChangedRegion {
  NodeKey node;
  std::vector<uint32_t> leaving, arriving;  ///< indices into the arguments of changedRegions()

  bool operator==(const ChangedRegion&) const = default;
};

/// Groups the nodes that only the old cover has with the nodes that only the new cover has.
/// @return regions in depth-first order. The node of a region is the shallowest of its nodes.
std::vector<ChangedRegion> changedRegions(std::span<const NodeKey> leaving,
                                          std::span<const NodeKey> arriving);

}  // namespace lode::render
