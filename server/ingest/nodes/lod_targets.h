#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace lode::ingest {

constexpr size_t kRootTriangles = 512;  ///< number of triangles at which the root's LODs end

struct LodRule {
  int depth = 0;
  bool is_leaf = false;             ///< leaves are not reduced, except a root that is a leaf
  size_t locked = 0;                ///< number of locked vertices in the node's input
  uint64_t original_triangles = 0;  ///< number of triangles in the leaves below the node
  size_t triangles_per_node = 0;
};

/// Returns the triangle counts of a node's reduced LODs, descending. The node's parent is made of the last
/// LOD, whose count is at most max(triangles_per_node, 8 * locked), or 12 * locked at depth 1 of a large
/// model. To bound the root's input, the multiple of `locked` is limited to 8 node capacities (at most 2^17
/// triangles; below depth 1, at least 2^14), but not below 4 * locked. The root locks nothing, and its LODs
/// end at kRootTriangles. Returns at least one count, unless the root is small already. Leaves out counts
/// above kMaxLodTriangles, the limit of a store.
///
/// With 8 * locked, about a quarter of the vertices of the parent's input could not move in the children;
/// with 12 * locked, a sixth; with 4 * locked, half. With half, a cut that passes from a node to its children
/// does not improve while its triangles grow by a factor of up to 3. See docs/decisions/0011-lod-ladder.md.
///
/// Each step halves the count. The root, and depths 1 and 2 of a large model, use steps of the square root of
/// 2: views of the whole model gain most from fine steps, and fine steps near the root add little to the
/// store.
///
/// Each locked vertex keeps about one triangle alive. If locked vertices keep most of the triangles, a step
/// leaves to the other triangles at least two thirds of the share that a plain step would leave. Otherwise a
/// node that is nearly all border would keep its border but lose its shape, and every level above would
/// inherit the error.
/// @param triangles  number of triangles in the node's input.
std::vector<size_t> lodTargets(size_t triangles, const LodRule& rule);

/// Returns the largest triangle count at which a node's LODs may end, so the largest number of triangles that
/// the node passes to its parent.
size_t mostTriangles(const LodRule& rule);

/// Returns the triangle counts of the far LODs, which come after the LOD that the parent is made of. Each far
/// LOD has about half the triangles of the previous one, down to a quarter of the node capacity or two
/// triangles per locked vertex. Views show far LODs outside the frustum, so a view close to the model loads
/// less. Only nodes with many nodes below them have far LODs; close to the leaves, far LODs would save few
/// bytes of a view and add many bytes to the store.
/// @param triangles  number of triangles in the LOD that the parent is made of.
std::vector<size_t> farLodTargets(size_t triangles, const LodRule& rule);

}  // namespace lode::ingest
