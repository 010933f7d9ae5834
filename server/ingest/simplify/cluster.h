#pragma once

#include <span>

#include "server/ingest/simplify/collapse.h"

namespace lode::ingest {

/// Simplifies a node's mesh by clustering in an octree over the node's box. The positions of a cell that are
/// not locked (see CollapseOptions) merge into one position, which lies at the optimum of the sum of their
/// quadrics. Cells merge in order of quadric error, children before parents, so that one sequence yields all
/// LODs. The root cell merges last and leaves a single unlocked position. cluster() gives the same guarantees
/// as collapse(): locked positions stay, positions are distinct lattice points, and a triangle disappears
/// only if two of its corners coincide, or together with a triangle of opposite orientation. Wedges of a cell
/// merge if triangle edges connect them. A merged wedge gets the attributes that are optimal at the new
/// position. Attributes that are not part of the quadrics are averaged. Faster than collapse(), but needs
/// more triangles for the same error. Deterministic, stateless, thread safe.
/// Sources: Lindstrom, Out-of-Core Simplification of Large Polygonal Models, 2000 (optimum per cell); Garland
/// & Heckbert 1998 and Hoppe 1999 for the quadrics (see collapse()).
void cluster(NodeMesh mesh, std::span<const size_t> targets, const CollapseOptions& options,
             const SnapshotSink& sink);

}  // namespace lode::ingest
