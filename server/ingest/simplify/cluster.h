#pragma once

#include <span>

#include "server/ingest/simplify/collapse.h"

namespace lode::ingest {

/// Simplifies a node's mesh by clustering in an octree over the node's box: the unlocked positions of a cell
/// merge into one, at the optimum of the cell's summed quadric. Cells merge in order of quadric error, inner
/// cells first, so one sequence yields all LODs; the last cell is the whole box and leaves one unlocked
/// position.
/// The contract is that of collapse(): locked positions stay, a triangle disappears only if two of its
/// corners coincide or together with an opposite one, and positions are distinct lattice points. Wedges of a
/// cell merge if triangle edges connect them; their attributes are the quadric's optimum, or the mean where
/// the quadric has none. Faster than collapse(), but coarser at the same error. Deterministic, stateless,
/// thread safe.
/// Sources: Lindstrom, Out-of-Core Simplification of Large Polygonal Models, 2000 (optimum per cell); Garland
/// & Heckbert 1998 and Hoppe 1999 for the quadrics (see collapse()).
void cluster(NodeMesh mesh, std::span<const size_t> targets, const CollapseOptions& options,
             const SnapshotSink& sink);

}  // namespace lode::ingest
