#pragma once

#include <span>

#include "server/ingest/simplify/collapse.h"

namespace lode::ingest {

/// Simplifies a node's mesh by clustering in an octree over the node's box: the unlocked positions of a cell
/// merge into one position, at the optimum of the sum of their quadrics. Cells merge in order of quadric
/// error, inner cells before outer ones, so one sequence yields all LODs. The last cell is the whole box, and
/// its merge leaves one unlocked position. The contract is the same as for collapse(): locked positions stay,
/// a triangle disappears only if two of its corners coincide or together with an opposite triangle, and
/// positions are distinct lattice points. Wedges of a cell merge if triangle edges connect them. A merged
/// wedge gets the attributes at the quadric's optimum, or the mean of attributes that the quadric does not
/// contain. Faster than collapse(), but coarser at the same error. Deterministic, stateless, thread safe.
/// Sources: Lindstrom, Out-of-Core Simplification of Large Polygonal Models, 2000 (optimum per cell); Garland
/// & Heckbert 1998 and Hoppe 1999 for the quadrics (see collapse()).
void cluster(NodeMesh mesh, std::span<const size_t> targets, const CollapseOptions& options,
             const SnapshotSink& sink);

}  // namespace lode::ingest
