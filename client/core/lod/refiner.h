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
  /// Best cut of the resident meshes, without textures; null if no resident meshes cover the model.
  std::shared_ptr<Cut> cut;
  std::vector<Request> wanted;  ///< missing pages and payloads, best first
  /// Resident meshes of the cut, of its fallbacks, and of nodes that can be shown once their siblings are
  /// resident.
  std::vector<MeshKey> in_use;
  std::vector<MeshKey> ancestors;  ///< resident meshes of nodes above the cut
  std::vector<NodeKey> pages;      ///< owners of the pages that the wanted or the published cut needs
  /// All meshes of the wanted cut; empty without RefineOptions::shares_memory.
  std::vector<WantedMesh> wanted_meshes;
  std::vector<HeldNode> held;  ///< states for the next refinement; empty without hysteresis
  bool limited = false;  ///< true if a budget stopped refinement before all errors were within the threshold
  /// True if the cut equals the wanted cut and is complete, so that no further blob can change it.
  bool settled = false;
};

/// The known and resident parts of a model.
struct KnownModel {
  const Hierarchy& hierarchy;
  const MeshCache& cache;
  double lattice_step = 1;
  AttributeSet attributes;  ///< attributes of all meshes
};

/// Best-first refinement: selects the wanted cut (see WantedCut), publishes the best cut that the resident
/// meshes allow, and requests the missing blobs. The result depends on the arguments alone, so the converged
/// cut does not depend on the order in which blobs arrive. The running time is proportional to the number of
/// nodes at and above the cut, not to the number of known nodes.
///
/// For each wanted part, the published cut contains the part itself if it is resident, otherwise a finer
/// stand-in that covers the node, otherwise a coarser stand-in. Children replace a node only when resident
/// meshes cover every child in the view or its margin. Missing children outside the margin are left out of
/// the cut and requested in the margin class, largest error first. Their nearest resident ancestor that fits
/// the fallback budget becomes their fallback, which is drawn as soon as one of them comes into view.
///
/// Refinement requests no LODs between the shown and the wanted LOD, except for one covering step: an
/// ancestor's LOD that is drawn until the wanted parts below it arrive, and has at most 1/20 of their bytes.
///
/// Occluded nodes belong to the cut like all nodes in the view. The siblings of an occluded node can be shown
/// as soon as the node's coarsest LOD is resident. The node's finer LODs are requested after all visible
/// blobs.
///
/// Source: best-first view-dependent refinement as in Duchaineau et al., ROAMing Terrain, 1997, over the
/// octree of Tan, Daman and Bade, 2005 (docs/lod-selection.md).
/// @param held  Refinement::held of the previous refinement; empty if there is none.
/// @param seen  places that this view sees; null treats no node as occluded. Changes the order of requests
///              and the stand-ins, but never the converged cut.
Refinement refine(const KnownModel& model, const View& view, const RefineOptions& options,
                  std::span<const HeldNode> held = {}, const SeenPlaces* seen = nullptr);

}  // namespace lode::core
