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
  uint64_t triangles = 0;         ///< triangles in the leaves' LOD 0
  uint64_t stored_triangles = 0;  ///< triangles in all LODs
  uint64_t payloads = 0;          ///< number of LODs with triangles
  uint32_t depth = 0;
};

/// Checks a whole hierarchy: key order, presence of exactly the children in the child masks, one LOD in each
/// leaf except the root, triangle counts that do not increase towards coarser LODs, finite errors that do not
/// decrease towards coarser LODs and parents (I3), boxes inside the parents' boxes, and limits.
/// @param nodes  in key order.
/// @throws Error kFormat or kLimit, naming the node. Thread safe.
HierarchyTotals checkHierarchy(std::span<const Node> nodes);

/// Finds the children of nodes in a checked hierarchy, by number. Siblings have consecutive numbers, because
/// nodes are in key order.
class NodeTree {
 public:
  /// @param nodes  nodes of a checked hierarchy, in key order; must outlive the tree.
  explicit NodeTree(std::span<const Node> nodes);

  std::span<const Node> nodes() const noexcept { return nodes_; }
  const Node& node(uint32_t number) const { return nodes_[number]; }
  uint32_t firstChild(uint32_t number) const { return first_child_[number]; }
  uint32_t childCount(uint32_t number) const noexcept;

 private:
  std::span<const Node> nodes_;
  std::vector<uint32_t> first_child_;
};

/// Returns a readable form of a key: "root", or the octants from the root down, like "root/3/0".
std::string describeKey(NodeKey key);

/// A page before it gets a blob number.
struct PagePlan {
  NodeKey owner;  ///< node above the topmost nodes of the page; for the first page the root, which that page
                  ///< also contains
  HierarchyPage page;
};

/// Returns the owner of the page that contains a node: the node's nearest ancestor of even depth >= 2, or the
/// root.
constexpr NodeKey pageOwner(NodeKey key) noexcept {
  const int depth = key.depth();
  return depth <= 2 ? kRootKey : key.ancestorAt((depth - 1) / 2 * 2);
}

/// Returns whether a node owns a page: it has children and an even depth >= 2.
inline bool ownsPage(const Node& node) noexcept {
  return node.key.depth() >= 2 && node.key.depth() % 2 == 0 && !node.isLeaf();
}

/// Distributes a checked hierarchy to pages as defined in hierarchy_page.h: the root's page first, then the
/// other pages in key order of their owners.
std::vector<PagePlan> splitIntoPages(std::vector<Node> nodes);

}  // namespace lode::store
