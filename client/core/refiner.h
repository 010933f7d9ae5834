#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "client/core/cache.h"
#include "client/core/cut.h"
#include "client/core/hierarchy.h"
#include "client/core/view.h"
#include "client/core/wish.h"

namespace lode::core {

constexpr uint64_t kPartBytes = 256;  ///< that a part of a cut takes beside its mesh, and where it has none
constexpr double kMarginWidening = 1.2;  ///< of the picture: what a camera that turns a little sees next

struct RefineOptions {
  float threshold_px = 1;
  uint64_t triangle_budget = std::numeric_limits<uint64_t>::max();
  uint64_t cut_budget_bytes = std::numeric_limits<uint64_t>::max();  ///< of decoded meshes in the wanted cut
  /// Of the known hierarchy: no page is asked for beyond it.
  uint64_t hierarchy_budget_bytes = std::numeric_limits<uint64_t>::max();
  bool finer_stand_ins = true;  ///< false: what is finer than wanted gives way to coarser ancestors at once
};

struct Refinement {
  std::shared_ptr<Cut> cut;        ///< without its textures; null while nothing covers the model yet
  std::vector<Wish> wanted;        ///< pages and payloads, not resident; best first
  std::vector<MeshKey> in_use;     ///< resident: the cut's meshes, and those that wait for their siblings
  std::vector<MeshKey> ancestors;  ///< resident: coarser stand-ins for the cut
  bool limited = false;            ///< a budget stopped the wanted cut above the threshold
  bool settled = false;            ///< the cut is the wanted one and whole: only another view will change it
};

/// Best-first refinement: decides what the view needs of the known hierarchy, publishes the best cut that the
/// resident meshes allow, and wishes for what is missing. A function of its arguments alone, so that the
/// converged cut does not depend on the order of arrivals.
///
/// The wanted cut starts at the root's coarsest rung; the part with the largest projected error gives way to
/// its next finer rung, or from rung 0 to its children at their coarsest, until no visible part is above the
/// threshold or a budget is reached. Parts outside the view are not refined.
///
/// The published cut is the wanted one where it is resident. Elsewhere a finer stand-in is kept if it covers
/// the place, else a coarser one: a node gives way to its children only when every child is covered that is
/// in the view or in a margin around it. Of the others those that are missing are left out of the cut, and
/// wished for in the margin class, coarsest first; where one comes into view the ancestor is shown again.
///
/// Levels between what is shown and what is wanted are skipped, but for one covering step that costs at most
/// a twentieth of the bytes of the wanted cut.
///
/// Source: best-first view-dependent refinement as in Duchaineau et al., ROAMing Terrain, 1997, over the
/// octree of the 2005 paper (docs/lod-selection.md).
Refinement refine(const Hierarchy& hierarchy, const MeshCache& cache, const Lattice& lattice,
                  AttributeSet attributes, const View& view, const RefineOptions& options);

}  // namespace lode::core
