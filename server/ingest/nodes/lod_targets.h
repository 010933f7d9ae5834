#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace lode::ingest {

constexpr size_t kRootTriangles = 512;  ///< number of triangles of the root's coarsest LOD

struct LodRule {
  int depth = 0;
  bool is_leaf = false;             ///< true for a leaf; leaves are not reduced, unless the leaf is the root
  size_t locked = 0;                ///< number of locked vertices in the node's input
  uint64_t original_triangles = 0;  ///< number of triangles in the leaves below the node
  size_t triangles_per_node = 0;
};

/// Returns the triangle counts of a node's reduced LODs, in descending order. The last LOD is the input of
/// the node's parent. Its count is at most max(triangles_per_node, 4 * locked, min(8 * locked, large)), where
/// `large` bounds the parent's input: 8 * triangles_per_node, but at most 2^17, and at depth 2 or deeper at
/// least 2^14. At depth 1 the factor 12 replaces 8 if the leaves below the node have at least
/// 16 * triangles_per_node triangles. The root locks nothing, and its LODs end at kRootTriangles. Returns at
/// least one count, unless the root is a leaf and already small. Omits counts above kMaxLodTriangles, the
/// limit of a store.
///
/// The factor determines how many vertices of the parent's input were locked in the children: about a quarter
/// with factor 8, a sixth with factor 12, half with factor 4. With factor 4, a picture does not improve when
/// a node is replaced by its children, although the number of triangles grows up to threefold. See
/// docs/decisions/0011-lod-ladder.md.
///
/// Each step halves the count. The root, and depths 1 and 2 of a large model, divide it by the square root of
/// 2 instead: views of the whole model gain most from fine steps, and fine steps near the root add little to
/// the store.
///
/// About one triangle must remain at each locked vertex. A step keeps these triangles, and at least 2/3 as
/// many of the others as it would keep if no vertex were locked. Otherwise a node that is nearly all border
/// would keep its border but lose its shape, and every level above would inherit the error.
/// @param triangles  number of triangles in the node's input.
std::vector<size_t> lodTargets(size_t triangles, const LodRule& rule);

/// Returns the largest number of triangles that the last LOD of lodTargets() can have.
size_t mostTriangles(const LodRule& rule);

/// Returns the triangle counts of the far LODs. Far LODs are coarser than the LOD from which the parent is
/// made. Each far LOD has about half the triangles of the previous LOD, down to a quarter of
/// triangles_per_node or two triangles per locked vertex, whichever is more. Clients show far LODs outside
/// the frustum, so that a view close to the model loads less. Only nodes with many nodes below them have far
/// LODs: near the leaves, far LODs would save few bytes of a view and add many bytes to the store.
/// @param triangles  number of triangles of the LOD from which the parent is made.
std::vector<size_t> farLodTargets(size_t triangles, const LodRule& rule);

}  // namespace lode::ingest
