#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/codec/hierarchy_page.h"
#include "common/lattice.h"

namespace lode::store {

/// Sums over all nodes of a hierarchy, for comparison with the store's header.
struct HierarchyTotals {
  uint64_t triangles = 0;         ///< triangles in the leaves' LOD 0
  uint64_t stored_triangles = 0;  ///< triangles in all LODs
  uint64_t payloads = 0;          ///< number of LODs with triangles
  uint32_t depth = 0;
};

/// Checks a whole hierarchy and its limits. Nodes must be in key order and have exactly the children of their
/// child masks. A leaf that is not the root must have exactly one LOD. Triangle counts must not increase
/// towards coarser LODs. Errors must be finite, and must not decrease towards coarser LODs or towards the
/// parent (I3). Each box must lie inside the parent's box.
/// @param nodes  in key order.
/// @throws Error kFormat or kLimit, naming the node. Thread safe.
HierarchyTotals checkHierarchy(std::span<const Node> nodes);

/// Finds the children of nodes in a checked hierarchy. A node's number is its index in key order, so siblings
/// have consecutive numbers.
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
  /// Parent of the topmost nodes of the page. The root owns the first page, which also contains the root.
  NodeKey owner;
  HierarchyPage page;
};

/// Returns the owner of the page that contains a node: the node's nearest ancestor of even depth >= 2, or the
/// root.
constexpr NodeKey pageOwner(NodeKey key) noexcept {
  const int depth = key.depth();
  return depth <= 2 ? kRootKey : key.ancestorAt((depth - 1) / 2 * 2);
}

/// Returns true if a node owns a page, because it has children and an even depth >= 2.
inline bool ownsPage(const Node& node) noexcept {
  return node.key.depth() >= 2 && node.key.depth() % 2 == 0 && !node.isLeaf();
}

/// Distributes a checked hierarchy to pages as defined in hierarchy_page.h: the root's page first, then the
/// other pages in key order of their owners.
std::vector<PagePlan> splitIntoPages(std::vector<Node> nodes);

}  // namespace lode::store
