#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "server/store/node_tree.h"

namespace lode::store {

/// One (node, LOD) of a cut, by the node's number in Reader::nodes().
struct CutItem {
  uint32_t node = 0;
  uint32_t lod = 0;

  bool operator==(const CutItem&) const = default;
};

/// A set of (node, LOD) that covers the model exactly once, in Morton order of the nodes' cells.
struct Cut {
  std::vector<CutItem> items;
  uint64_t triangles = 0;
  float max_error_model = 0;  ///< of the items that have triangles
  bool converged = true;      ///< the bound that was asked for is kept
};

/// The coarsest (node, LOD) everywhere whose error is at most `max_error_model`; where even a leaf's is
/// larger, the leaf, and the cut is not converged. Errors are geometric ones, here and below.
Cut cutByError(const NodeTree& tree, double max_error_model);

/// The best cut of at most `max_triangles`: best-first refinement by largest error; a step that does not fit
/// is left out, and smaller ones are tried until none fits. A step leads to a node's next finer LOD, after
/// LOD 0 to the children's coarsest ones. Not converged, and then the coarsest cut of all, if that has more
/// triangles already. Ties go by node key.
Cut cutByTriangles(const NodeTree& tree, uint64_t max_triangles);

/// A random cut with random LODs, the same for a seed everywhere; seeds differ in how deep they go.
Cut randomCut(const NodeTree& tree, uint64_t seed);

/// All leaves at LOD 0: the original triangles.
Cut leafCut(const NodeTree& tree);

/// True if every path from the root to a leaf meets exactly one item, and every LOD exists.
bool coversExactlyOnce(const NodeTree& tree, std::span<const CutItem> items);

}  // namespace lode::store
