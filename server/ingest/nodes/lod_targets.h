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
/// the node's parent. Its count is at most max(triangles_per_node, 8 * locked); at depth 1 of a large model,
/// the factor is 12 instead of 8. To bound the root's input, the multiple of `locked` has a limit of 8 node
/// capacities: at most 2^17 triangles and, below depth 1, at least 2^14. The limit does not apply below 4 *
/// locked. The root locks nothing, and its LODs end at kRootTriangles. Returns at least one count, unless the
/// root is already small. Omits counts above kMaxLodTriangles, the limit of a store.
///
/// The factor decides how many vertices of the parent's input could not move in the children: about a quarter
/// with factor 8, a sixth with factor 12, half with factor 4. With factor 4, a cut that passes from a node to
/// its children does not improve, although its triangles grow up to threefold. See
/// docs/decisions/0011-lod-ladder.md.
///
/// Each step halves the count. The root, and depths 1 and 2 of a large model, use steps of the square root of
/// 2: views of the whole model gain most from fine steps, and fine steps near the root add little to the
/// store.
///
/// Each locked vertex keeps about one triangle. If most triangles belong to locked vertices, a step keeps at
/// least 2/3 as many triangles without locked vertices as a plain step would keep. Otherwise a node that is
/// nearly all border would keep its border but lose its shape, and every level above would inherit the error.
/// @param triangles  number of triangles in the node's input.
std::vector<size_t> lodTargets(size_t triangles, const LodRule& rule);

/// Returns the largest number of triangles that a node's last LOD can have. A node passes this LOD to its
/// parent.
size_t mostTriangles(const LodRule& rule);

/// Returns the triangle counts of the far LODs. Far LODs are coarser than the LOD from which the parent is
/// made. Each far LOD has about half the triangles of the previous LOD, down to a quarter of the node
/// capacity or two triangles per locked vertex. Clients show far LODs outside the frustum, so that a view
/// close to the model loads less. Only nodes with many nodes below them have far LODs; close to the leaves,
/// far LODs would save few bytes of a view and add many bytes to the store.
/// @param triangles  number of triangles of the LOD from which the parent is made.
std::vector<size_t> farLodTargets(size_t triangles, const LodRule& rule);

}  // namespace lode::ingest
