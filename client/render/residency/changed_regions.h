#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "common/node_key.h"

namespace lode::render {

/// Sort key for depth-first order, in which a node precedes its descendants.
constexpr std::pair<uint64_t, int> depthFirst(NodeKey node) noexcept {
  return {node.value << 3 * (kMaxDepth - node.depth()), node.depth()};
}

/// A region of the model in which arriving parts replace leaving parts: the region's node and everything
/// below the node. The leaving parts and the arriving parts both cover the region.
struct ChangedRegion {
  NodeKey node;
  std::vector<uint32_t> leaving, arriving;  ///< indices into the arguments of changedRegions()

  bool operator==(const ChangedRegion&) const = default;
};

/// Groups nodes into regions.
/// @param leaving  nodes of the parts that were shown and no longer are.
/// @param arriving  nodes of the parts that are newly shown.
/// @return regions in depth-first order. A region's node is the shallowest of the nodes in the region.
std::vector<ChangedRegion> changedRegions(std::span<const NodeKey> leaving,
                                          std::span<const NodeKey> arriving);

}  // namespace lode::render
