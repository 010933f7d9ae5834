#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace lode::ingest {

constexpr size_t kRootTriangles = 512;  ///< the root's LODs end here

struct LodRule {
  int depth = 0;
  bool is_leaf = false;             ///< leaves are not reduced, except a root that is a leaf
  size_t locked = 0;                ///< number of locked vertices in the node's input
  uint64_t original_triangles = 0;  ///< in the leaves below the node
  size_t triangles_per_node = 0;
};

/// Triangle counts of a node's reduced LODs, descending; the node's parent is made of the last. They end at
/// or below max(triangles_per_node, 8 * locked), with 12 * locked at depth 1 of a large model. If that is
/// more than 8 node capacities or 2^17 triangles (below depth 1 at least 2^14), 4 * locked replaces it, to
/// bound the root's input. The root locks nothing and ends at kRootTriangles. Returns at least one count,
/// except for a root that is small already. Counts above kMaxLodTriangles, the limit of a store, are left
/// out.
///
/// With 8 * locked, about a quarter of the vertices that a parent is made of cannot move below it; at 12 *
/// locked, a sixth; at 4 * locked, half, and cuts that pass from a node to its children stall over a factor
/// of up to 3 in triangles. See docs/decisions/0011-lod-ladder.md.
///
/// Each step halves the count. The root, and depths 1 and 2 of a large model, use steps of the square root of
/// 2: views of the whole model gain most from fine steps, and there they cost the store little.
///
/// Each locked vertex holds about one triangle. Where locked vertices hold most of the triangles, a step
/// reduces the others to no less than two thirds of the plain step: otherwise a node that is nearly all
/// border would keep only its border, without its shape, and every level above would inherit the error.
/// @param triangles  of the node's input.
std::vector<size_t> lodTargets(size_t triangles, const LodRule& rule);

/// Largest triangle count at which a node's LODs end, so the most that it passes to its parent.
size_t mostTriangles(const LodRule& rule);

/// Triangle counts of the far LODs, which follow: halves, until at most a quarter of the node capacity or two
/// triangles per locked vertex. Views use far LODs for parts outside the frustum, so that moving close loads
/// less. Only nodes with many others below have them: close to the leaves they would save few bytes of a view
/// and add many to the store.
/// @param triangles  of the LOD that the parent is made of.
std::vector<size_t> farLodTargets(size_t triangles, const LodRule& rule);

}  // namespace lode::ingest
