#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/codec/blob.h"
#include "server/ingest/nodes/tree_plan.h"

namespace lode::ingest {

/// A treelet: one node of the octree, its root, and all nodes below the root except those in treelets farther
/// below. A build writes each finished treelet to a file of its own (see TreeletWriter), so that resumed
/// builds, builds of an edited model and the jobs of a cluster can share it.
struct Treelet {
  /// Name of the file: digest of the settings, of the leaves in the treelet and of the names of the treelets
  /// directly below. Treelets with equal names have equal nodes.
  Digest name;
  uint32_t root = 0;        ///< number of the root in the TreePlan
  uint32_t nodes = 0;       ///< number of nodes
  uint64_t leaf_bytes = 0;  ///< size of the meshes of all leaves below the root, a measure of the work
};

/// A leaf of the octree, as far as treelets depend on it.
struct LeafOfTreelet {
  Digest digest;       ///< digest of the leaf's mesh and of the vertices that it shares with other leaves
  uint64_t bytes = 0;  ///< size of the mesh
};

/// Divides an octree into treelets. The root of the tree is the root of a treelet, and so is each node with
/// more than kMaxLeavesInside leaves below it. Immutable; const functions are thread safe.
class TreeletPlan {
 public:
  /// A node with at most this many leaves below it lies in its parent's treelet.
  static constexpr uint32_t kMaxLeavesInside = 2;

  /// @param tree  must outlive this object. @param leaves  the leaves in the order of the TreePlan.
  /// @param settings  digest of everything besides the leaves that determines the nodes.
  TreeletPlan(const TreePlan& tree, std::span<const LeafOfTreelet> leaves, const Digest& settings);

  size_t size() const noexcept { return treelets_.size(); }
  /// Returns all treelets. Treelets come before the treelet above them.
  std::span<const Treelet> all() const noexcept { return treelets_; }
  const Treelet& operator[](uint32_t number) const noexcept { return treelets_[number]; }
  /// Returns the number of the treelet that contains a node of the TreePlan.
  uint32_t treeletOf(uint32_t node) const noexcept { return treelet_of_[node]; }
  /// Returns the depth of a treelet's root.
  int depth(uint32_t number) const noexcept { return tree_.key(treelets_[number].root).depth(); }
  /// Returns the number of the treelet directly above. @pre the treelet is not the last one.
  uint32_t above(uint32_t number) const noexcept { return above_[number]; }
  /// Returns the numbers of the treelets directly below a treelet, in ascending order.
  std::vector<uint32_t> below(uint32_t number) const;

 private:
  void findRoots();
  void listBelow();
  void computeNames(std::span<const LeafOfTreelet> leaves, const Digest& settings);

  const TreePlan& tree_;
  std::vector<Treelet> treelets_;
  std::vector<uint32_t> above_;  ///< number of the treelet directly above each; the last one has none
  std::vector<uint32_t> first_below_, next_beside_;  ///< lists of the treelets directly below each treelet
  std::vector<uint32_t> treelet_of_;
};

}  // namespace lode::ingest
