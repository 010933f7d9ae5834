#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/codec/hierarchy_page.h"
#include "common/lattice.h"

namespace lode::store {

/// Sums over a hierarchy, for comparison with the header.
struct HierarchyTotals {
  uint64_t triangles = 0;         ///< in the leaves' LOD 0
  uint64_t stored_triangles = 0;  ///< in all LODs
  uint64_t payloads = 0;          ///< LODs with triangles
  uint32_t depth = 0;
};

/// Checks a whole hierarchy: key order, children present exactly as in the masks, one LOD in leaves below the
/// root, triangle counts that do not increase towards coarser LODs, errors finite and monotone (I3), boxes
/// inside the parents' boxes, limits.
/// @param nodes  in key order.
/// @throws Error kFormat or kLimit, naming the node. Thread safe.
HierarchyTotals checkHierarchy(std::span<const Node> nodes);

/// Finds children by number in a checked hierarchy; in key order siblings are adjacent.
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

/// A readable key: "root", or the octants from the root down, like "root/3/0".
std::string describeKey(NodeKey key);

/// A page before it gets a blob number.
struct PagePlan {
  NodeKey
      owner;  ///< node that the page hangs below; the root for the first page, which contains the root itself
  HierarchyPage page;
};

/// Owner of the page that contains a node: the nearest ancestor of even depth >= 2, or the root.
constexpr NodeKey pageOwner(NodeKey key) noexcept {
  const int depth = key.depth();
  return depth <= 2 ? kRootKey : key.ancestorAt((depth - 1) / 2 * 2);
}

/// Returns true if a page hangs below the node: if it has children and an even depth >= 2.
inline bool ownsPage(const Node& node) noexcept {
  return node.key.depth() >= 2 && node.key.depth() % 2 == 0 && !node.isLeaf();
}

/// Distributes a checked hierarchy to pages as defined in hierarchy_page.h: the root's page first, then in
/// key order of their owners.
std::vector<PagePlan> splitIntoPages(std::vector<Node> nodes);

}  // namespace lode::store
