#pragma once

#include <vector>

#include "common/codec/hierarchy_page.h"

namespace lode::store {

/// A page before it has a number: the node below which it hangs and what it holds.
struct PagePlan {
  NodeKey owner;  ///< of the first page the root, which that page holds itself
  HierarchyPage page;
};

/// The node below whose page a node stands: the nearest ancestor of even depth >= 2, or the root.
constexpr NodeKey pageOwner(NodeKey key) noexcept {
  const int depth = key.depth();
  return depth <= 2 ? kRootKey : key.ancestorAt((depth - 1) / 2 * 2);
}

/// True if a page hangs below the node: it has even depth >= 2 and children.
inline bool ownsPage(const Node& node) noexcept {
  return node.key.depth() >= 2 && node.key.depth() % 2 == 0 && !node.isLeaf();
}

/// Deals a checked hierarchy out to pages as hierarchy_page.h says; the root's first, then in the order of
/// their owners' keys.
std::vector<PagePlan> splitIntoPages(std::vector<Node> nodes);

}  // namespace lode::store
