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
  std::shared_ptr<Cut> cut;        ///< without textures; null while no resident mesh covers the model
  std::vector<Request> wanted;     ///< missing pages and payloads, best first
  std::vector<MeshKey> in_use;     ///< resident meshes of the cut, fallbacks and nodes waiting for siblings
  std::vector<MeshKey> ancestors;  ///< resident meshes of nodes above the cut
  std::vector<NodeKey> pages;      ///< owners of the pages that either cut passes through
  std::vector<WantedMesh> wanted_meshes;  ///< all wanted meshes; needs RefineOptions::shares_memory
  std::vector<HeldNode> held;             ///< input of the next refinement; needs hysteresis
  bool limited = false;                   ///< a budget stopped the wanted cut above the threshold
  bool settled = false;  ///< the cut is the wanted one and complete: only a new view changes it
};

/// Best-first refinement: selects the wanted cut (see WantedCut), publishes the best cut that the resident
/// meshes allow, and requests the missing blobs. The result depends on the arguments alone, so the converged
/// cut does not depend on the order of arrivals. The running time is proportional to the nodes that the cut
/// passes through, not to the known nodes.
///
/// The published cut equals the wanted cut where that is resident. Elsewhere it keeps a finer stand-in that
/// covers the node, else a coarser one. Children replace a node only when resident meshes cover every child
/// in the view or its margin. Missing children outside the margin are left out of the cut and requested in
/// the margin class, coarsest first. Their nearest resident ancestor that fits the fallback budget becomes
/// their fallback and is drawn again when one of them comes into view.
///
/// LODs between the shown and the wanted one are skipped, except for one covering step that costs at most a
/// twentieth of the wanted cut's bytes.
///
/// Hidden nodes belong to the cut like all nodes in the view, but their coarsest LOD suffices for their
/// siblings to be shown; their finer LODs are requested after everything visible.
///
/// Source: best-first view-dependent refinement as in Duchaineau et al., ROAMing Terrain, 1997, over the
/// octree of the 2005 paper (docs/lod-selection.md).
/// @param held  Refinement::held of the previous refinement.
/// @param seen  places that this view sees; null: treats nothing as hidden. Changes the order of requests
///              and the stand-ins, never the converged cut.
Refinement refine(const Hierarchy& hierarchy, const MeshCache& cache, const Lattice& lattice,
                  AttributeSet attributes, const View& view, const RefineOptions& options,
                  std::span<const HeldNode> held = {}, const SeenPlaces* seen = nullptr);

}  // namespace lode::core
