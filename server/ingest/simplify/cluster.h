#pragma once

#include <span>

#include "server/ingest/simplify/collapse.h"

namespace lode::ingest {

/// Simplifies a node's mesh by clustering: in an octree over the node's box, the positions of a cell that are
/// not locked become one, at the optimum of the cell's summed quadric. Cells go in order of that quadric's
/// error, each after those within it, so that one sequence yields all LODs; the last is the whole box, which
/// leaves one position beside the locked ones. Same contract as collapse(): locked positions stay, a triangle
/// goes only when two of its corners coincide or with an opposite one, positions come to lie on the lattice
/// and stay apart. Wedges of a cell become one where triangles' edges connect them, with the attributes that
/// the quadric calls best, or where it knows none their mean. Faster than collapse() and coarser for the same
/// error. Deterministic. Thread safe (no state).
/// Sources: Lindstrom, Out-of-Core Simplification of Large Polygonal Models, 2000, for optima in cells;
/// Garland & Heckbert 1998 and Hoppe 1999 for the quadrics (see collapse()).
void cluster(NodeMesh mesh, std::span<const size_t> targets, const CollapseOptions& options,
             const SnapshotSink& sink);

}  // namespace lode::ingest
