#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "server/store/node_tree.h"

namespace lode::store {

/// A (node, LOD) of a cut; `node` is an index in Reader::nodes().
struct CutItem {
  uint32_t node = 0;
  uint32_t lod = 0;

  bool operator==(const CutItem&) const = default;
};

/// A set of (node, LOD) pairs that covers the model exactly once, in Morton order of the nodes' cells.
struct Cut {
  std::vector<CutItem> items;
  uint64_t triangles = 0;
  float max_error_model = 0;  ///< of the items with triangles
  bool converged = true;      ///< the requested bound is met
};

/// Takes everywhere the coarsest (node, LOD) whose error is at most `max_error_model`. If even a leaf's error
/// is larger, takes the leaf, and the cut is not converged. Uses geometric errors, like all functions here.
Cut cutByError(const NodeTree& tree, double max_error_model);

/// Best cut of at most `max_triangles`: refines the largest error first, to the node's next finer LOD, or
/// after LOD 0 to the children's coarsest LODs. Skips steps that exceed the limit and tries others until none
/// fits. If even the coarsest cut has more triangles, returns it, not converged. Ties are broken by node key.
Cut cutByTriangles(const NodeTree& tree, uint64_t max_triangles);

/// A random cut with random LODs. The same seed gives the same cut on all platforms; seeds differ in depth.
Cut randomCut(const NodeTree& tree, uint64_t seed);

/// All leaves at LOD 0, the original triangles.
Cut leafCut(const NodeTree& tree);

/// Returns true if every path from the root to a leaf contains exactly one item, and every item's LOD exists.
bool coversExactlyOnce(const NodeTree& tree, std::span<const CutItem> items);

}  // namespace lode::store
