#pragma once

#include <memory>
#include <span>
#include <vector>

#include "client/core/cache/mesh_cache.h"
#include "client/core/lod/cut.h"
#include "client/core/lod/hierarchy.h"
#include "client/core/lod/refine_options.h"
#include "client/core/lod/request.h"
#include "client/core/lod/seen_places.h"
#include "client/core/lod/wanted_cut.h"
#include "client/core/view/view.h"

namespace lode::core {

struct Refinement {
  std::shared_ptr<Cut> cut;     ///< without its textures; null while nothing covers the model yet
  std::vector<Request> wanted;  ///< pages and payloads, not resident; best first
  std::vector<MeshKey> in_use;  ///< resident: the cut's meshes, its fallbacks', and what waits for siblings
  std::vector<MeshKey> ancestors;  ///< resident: coarser stand-ins for the cut
  std::vector<NodeKey> pages;      ///< owners of those that the wanted cut and the published one go through
  std::vector<WantedMesh> wanted_meshes;  ///< all of the wanted cut, where they are to be listed
  std::vector<HeldNode> held;             ///< for the next refinement, where it is to have hysteresis
  bool limited = false;                   ///< a budget stopped the wanted cut above the threshold
  bool settled = false;  ///< the cut is the wanted one and whole: only another view will change it
};

/// Best-first refinement: decides what the view needs of the known hierarchy, publishes the best cut that the
/// resident meshes allow, and requests what is missing. A function of its arguments alone, so that the
/// converged cut does not depend on the order of arrivals. Its time goes with the nodes that the cut goes
/// through, not with those that are known.
///
/// What is wanted: see WantedCut. The published cut is the wanted one where it is resident. Elsewhere a finer
/// stand-in is kept if it covers the place, else a coarser one: a node gives way to its children only when
/// every child is covered that is in the view or in a margin around it. Of the others those that are missing
/// are left out of the cut, and requested in the margin class, coarsest first; the nearest ancestor that is
/// resident, as far as memory is for it, is their fallback, and where one comes into view the ancestor is
/// shown again.
///
/// Levels between what is shown and what is wanted are skipped, but for one covering step that costs at most
/// a twentieth of the bytes of the wanted cut.
///
/// What is behind other parts is in the cut like all that is in the view, but its node's coarsest LOD is
/// enough for its siblings to be shown; what is finer comes after all that is seen.
///
/// Source: best-first view-dependent refinement as in Duchaineau et al., ROAMing Terrain, 1997, over the
/// octree of the 2005 paper (docs/lod-selection.md).
/// @param held  of the last refinement.
/// @param seen  by this view; null: nothing is known to be hidden. It changes the order of requests and what
/// is
///              shown meanwhile, never the cut that has converged.
Refinement refine(const Hierarchy& hierarchy, const MeshCache& cache, const Lattice& lattice,
                  AttributeSet attributes, const View& view, const RefineOptions& options,
                  std::span<const HeldNode> held = {}, const SeenPlaces* seen = nullptr);

}  // namespace lode::core
