#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/codec/hierarchy_page.h"
#include "common/lattice.h"

namespace lode::store {

/// Sums over a hierarchy, to compare with what a header says.
struct HierarchyTotals {
  uint64_t triangles = 0;         ///< in the leaves' LOD 0
  uint64_t stored_triangles = 0;  ///< in all LODs
  uint64_t payloads = 0;          ///< LODs with triangles
  uint32_t depth = 0;
};

/// Checks a whole hierarchy, as it comes from pages or from a build: key order, every child of a mask present
/// and no orphan, one LOD in leaves below the root, triangle counts that do not rise towards coarser LODs,
/// errors finite and monotone (I3), boxes inside the parents' boxes, limits.
/// @param nodes  in key order.
/// @throws Error kFormat or kLimit, naming the node. Thread safe.
HierarchyTotals checkHierarchy(std::span<const Node> nodes);

/// Finds children by number in a checked hierarchy: nodes in key order have siblings side by side.
class NodeTree {
 public:
  /// @param nodes  checked, in key order; must outlive the tree.
  explicit NodeTree(std::span<const Node> nodes);

  std::span<const Node> nodes() const noexcept { return nodes_; }
  const Node& node(uint32_t number) const { return nodes_[number]; }
  uint32_t firstChild(uint32_t number) const { return first_child_[number]; }
  uint32_t childCount(uint32_t number) const noexcept;

 private:
  std::span<const Node> nodes_;
  std::vector<uint32_t> first_child_;
};

/// A key as people read it: "root" or the octants from the root down, "root/3/0".
std::string describeKey(NodeKey key);

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
