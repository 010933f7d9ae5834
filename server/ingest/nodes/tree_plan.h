#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/node_key.h"

namespace lode::ingest {

/// The octree that has the given leaves. Nodes are numbered in post-order: children come before their parent,
/// and the root is last. Const functions are thread safe.
class TreePlan {
 public:
  /// @param leaves  all leaves of one tree, in Morton order.
  explicit TreePlan(const std::vector<NodeKey>& leaves);

  size_t size() const noexcept { return entries_.size(); }
  NodeKey key(uint32_t number) const noexcept { return entries_[number].key; }
  bool isRoot(uint32_t number) const noexcept { return number + 1 == entries_.size(); }
  /// @pre the node is not the root.
  uint32_t parent(uint32_t number) const noexcept { return entries_[number].parent; }
  bool isLeaf(uint32_t number) const noexcept { return entries_[number].first == number; }
  /// Returns the index of a leaf in the list that the constructor received.
  uint32_t leaf(uint32_t number) const noexcept { return entries_[number].leaf; }
  /// Returns the numbers of a node's children, in octant order.
  std::vector<uint32_t> children(uint32_t number) const;

 private:
  struct Entry {
    NodeKey key;
    uint32_t parent = 0;
    uint32_t first = 0;  ///< smallest number of a node in the subtree
    uint32_t leaf = 0;   ///< index of the subtree's first leaf
  };
  void plan(NodeKey key, const std::vector<NodeKey>& leaves, size_t& next);

  std::vector<Entry> entries_;
};

}  // namespace lode::ingest
