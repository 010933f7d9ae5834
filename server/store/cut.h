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
  float max_error_model = 0;  ///< largest error of the items with triangles, in model units
  bool converged = true;      ///< true if the cut meets the requested bound
};

/// Returns the cut of the coarsest (node, LOD) pairs whose errors are at most `max_error_model`. If the error
/// of a leaf's LOD 0 is larger, the cut contains this LOD and is not converged. All functions in this file
/// use geometric errors and ignore appearance errors.
Cut cutByError(const NodeTree& tree, double max_error_model);

/// Returns the best cut of at most `max_triangles` triangles that a greedy search finds. Starts with the
/// coarsest cut and always refines the item with the largest error; among equal errors, the node key decides.
/// An item is refined to the node's next finer LOD, or from LOD 0 to the children's coarsest LODs with no
/// larger error. Steps that exceed the limit are skipped; the search ends when no step fits. If even the
/// coarsest cut has too many triangles, returns the coarsest cut as not converged.
Cut cutByTriangles(const NodeTree& tree, uint64_t max_triangles);

/// Returns a random cut with random LODs. The same seed yields the same cut on all platforms; cuts of
/// different seeds differ in depth.
Cut randomCut(const NodeTree& tree, uint64_t seed);

/// Returns the cut of all leaves at LOD 0. This cut has the original triangles.
Cut leafCut(const NodeTree& tree);

/// Returns true if every path from the root to a leaf contains exactly one item, and the LOD of each item
/// exists.
bool coversExactlyOnce(const NodeTree& tree, std::span<const CutItem> items);

}  // namespace lode::store
