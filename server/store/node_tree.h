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

}  // namespace lode::store
