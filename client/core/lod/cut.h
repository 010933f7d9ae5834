#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "client/core/textures/tile.h"
#include "client/core/view/view.h"
#include "common/codec/texture_set.h"
#include "common/image/tile_image.h"
#include "common/mesh.h"
#include "common/node_key.h"

namespace lode::core {

/// A part of a cut: one LOD of a node. The mesh is shared with the cache and never changes.
struct CutPart {
  NodeKey node;
  uint32_t lod = 0;
  /// False if the part lies outside the view and only completes the cut, or if it is a fallback.
  bool visible = true;
  float error_px = 0;  ///< projected error in the cut's view: partErrorPx() if the part is visible
  std::shared_ptr<const Mesh> mesh;
  float error_model = 0;  ///< largest distance between the mesh and the original surface
  float off_model = 0;    ///< the larger of error_model and the appearance error
  /// Threshold at which refinement would select this part. A wanted part has the cut's threshold. A stand-in,
  /// which is shown in place of a missing part, has min(threshold, error_px) if it is finer than the missing
  /// part, and max(threshold, error_px) if it is coarser.
  float threshold_px = 0;
  ModelBox box = {};  ///< bounding box of the node
};

/// A texture tile to draw. The image is shared with the cache and never changes. Tiles with equal contents
/// share one image.
struct ResidentTile {
  TileKey key;
  std::shared_ptr<const TileImage> image;
};

/// A node outside the view that the cut leaves out because its mesh is missing.
struct LeftOut {
  NodeKey node;
  ModelBox box;
};

/// A coarser part for a node below which the cut leaves out other nodes. As soon as a camera sees one of the
/// left-out nodes, the fallback is drawn in place of all parts below its own node: see shownParts(). The
/// index ranges refer to the vectors of the cut and exclude their ends.
struct Fallback {
  CutPart part;
  uint32_t first_part = 0, end_part = 0;  ///< index range of the parts below the fallback's node
  /// Index range of the left-out nodes whose nearest fallback is this fallback.
  uint32_t first_left_out = 0, end_left_out = 0;
  /// The fallbacks below this fallback's node have the indices from first_nested up to, but excluding, its
  /// own index.
  uint32_t first_nested = 0;
};

/// Parts that cover the model exactly once. The parts are in depth-first order, siblings by octant. The
/// refiner publishes immutable cuts, and the renderer reads them on another thread. A cut omits parts without
/// triangles. Until the cut has settled, parts outside the view and its margin may also be missing; call
/// shownParts() to draw the cut for a camera that has moved.
struct Cut {
  View view;                ///< view of the refinement
  float threshold_px = 1;   ///< largest projected error that the refinement allowed
  uint64_t build = 0;       ///< Model::build()
  double lattice_step = 0;  ///< size of a lattice step in model units
  std::vector<CutPart> parts;
  std::vector<LeftOut> left_out;    ///< nodes of missing parts, all outside the view; each has a fallback
  std::vector<Fallback> fallbacks;  ///< fallbacks of all depths, children before parents
  uint64_t triangles = 0;
  uint64_t blob_bytes = 0;   ///< encoded size of the meshes and tiles that the cut uses
  uint64_t drawn_bytes = 0;  ///< GPU memory of the parts and fallbacks: see drawnBytes()
  float max_error_px = 0;    ///< largest projected error of the visible parts
  float refinable_px = 0;    ///< largest projected error of visible parts that can be refined
  /// True if no visible part exceeds the threshold, except leaves that show their original triangles, and if
  /// every tile that fits the texture budget is resident or lost.
  bool converged = false;
  /// Number of visible tiles that cannot be loaded; a lost texture set counts as one tile.
  uint64_t lost_tiles = 0;
  /// Null if the model has no textures or the set is not loaded yet.
  std::shared_ptr<const TextureSet> textures;
  std::vector<ResidentTile> tiles;  ///< sorted by key, coarse levels first
};

/// Returns the threshold as an angle, which does not depend on the picture size. Multiply the angle by
/// focalPx() of another view to get that view's threshold in pixels.
inline double thresholdRad(const Cut& cut) noexcept { return cut.threshold_px / focalPx(cut.view); }

constexpr float kFarOffFactor = 2;

/// Returns true if a visible part that can be refined has more than kFarOffFactor times the requested error.
/// @param cut  null if nothing is resident yet; the function then returns true.
inline bool isFarOff(const Cut* cut, float threshold_px) noexcept {
  return cut == nullptr || cut->refinable_px > kFarOffFactor * threshold_px;
}

/// Parts and fallbacks of a cut share one numbering: parts first, then fallbacks.
inline size_t partCount(const Cut& cut) noexcept { return cut.parts.size() + cut.fallbacks.size(); }
/// @param number  number less than partCount().
inline const CutPart& partOf(const Cut& cut, size_t number) noexcept {
  return number < cut.parts.size() ? cut.parts[number] : cut.fallbacks[number - cut.parts.size()].part;
}

/// Selects the parts to draw for any camera. If the camera sees a left-out node, that node's fallback
/// replaces all parts below the fallback's own node. The selected parts cover the visible surface exactly
/// once.
/// @return numbers for partOf(), depth first.
std::vector<uint32_t> shownParts(const Cut& cut, const View& view);

/// Returns the largest projected error of the drawn parts that a camera sees; 0 if the camera sees no part.
/// @param shown  numbers for partOf().
float shownErrorPx(const Cut& cut, std::span<const uint32_t> shown, const View& view);

/// Counts the left-out nodes that a camera sees and that no drawn part covers.
/// @param shown  numbers for partOf().
size_t countHoles(const Cut& cut, std::span<const uint32_t> shown, const View& view);

/// The cuts of one model for all of its views, which share meshes. Immutable.
struct ViewCuts {
  std::vector<std::shared_ptr<const Cut>> cuts;  ///< indexed by view
  /// Union of the cuts. For one view, the union is the view's cut. For several views, the union contains the
  /// parts and fallbacks of all cuts, each mesh once, and the textures. Its triangle count is the sum over
  /// the cuts, and each of its errors is the maximum over the cuts.
  std::shared_ptr<const Cut> all;
};

/// Builds the union of several cuts as ViewCuts::all describes, but without textures.
/// @param cuts  at least one cut; all have the same build and threshold.
std::shared_ptr<Cut> gatherMeshes(std::span<const std::shared_ptr<const Cut>> cuts);

}  // namespace lode::core
