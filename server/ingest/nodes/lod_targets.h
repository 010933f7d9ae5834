#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace lode::ingest {

constexpr size_t kRootTriangles = 512;  ///< to which the root's LODs go down

struct LodRule {
  int depth = 0;
  bool is_leaf = false;             ///< only the root's leaf is reduced at all
  size_t locked = 0;                ///< locked vertices of the node's input
  uint64_t original_triangles = 0;  ///< in the leaves below the node
  size_t triangles_per_node = 0;
};

/// Triangle counts of the reduced LODs of a node of which its parent is made at the last, falling, until at
/// most max(triangles_per_node, 8 * locked), at depth 1 of a large model 12 * locked, or 4 * locked where
/// that is more than 8 budgets or 2^17 triangles, so that what the root is made of has a bound; below depth 1
/// 2^14 triangles are allowed, whatever the budget. At the root, which locks nothing, until kRootTriangles.
/// At least one, but for a root that is small enough already. Steps above kMaxLodTriangles, which no store
/// takes, are left out.
///
/// So at most about a quarter of the vertices that a parent is made of cannot move below it, and a sixth of
/// the root's. With 4 * locked it is half of them, and cuts that pass from a node to its children stand still
/// over a factor of up to 3 in triangles; more of them serves views from afar no better, but where the root
/// ends. (docs/benchmarks.md, "Locked borders", has the measurements.)
///
/// Steps are of 2; of the square root of 2 at the root, and at depths 1 and 2 where much lies below the node,
/// so that the finer steps, which a view of the whole model profits from most, cost the store little: with
/// them at depths 0 to 2 of every model, one of 2 million triangles stores 3.4 times its triangles, with this
/// rule 2.1 times.
///
/// Locked vertices hold a triangle each. Where there are so many of them that a step would leave little else,
/// it stops at two thirds of it of what they do not hold: half of a node that is nearly all border is its
/// border alone, without its shape, and every level above inherits that error. (9 million triangles at 512 a
/// node: the root's finest LOD had an error of 7.5e-3 of the diagonal without this and has 2.3e-3 with it.)
/// @param triangles  of the node's input.
std::vector<size_t> lodTargets(size_t triangles, const LodRule& rule);

/// At how many triangles a node's LODs end, so the most that it gives its parent.
size_t mostTriangles(const LodRule& rule);

/// Triangle counts of the far LODs that follow: halves, until at most a quarter of the budget or two a
/// locked vertex. They are what a view shows of parts beside it, so that coming close costs less of what is
/// not seen. Only where much lies below the node: close to the leaves they would save little of a view's
/// bytes for much of the store's.
/// @param triangles  of the LOD that the parent is made of.
std::vector<size_t> farLodTargets(size_t triangles, const LodRule& rule);

}  // namespace lode::ingest
