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

/// One mesh to draw. The cache shares the mesh, which never changes.
struct CutPart {
  NodeKey node;
  uint32_t lod = 0;
  bool visible = true;  ///< false: outside the view; kept for completeness or as a fallback
  float error_px = 0;   ///< off_model projected into the view of the refinement
  std::shared_ptr<const Mesh> mesh;
  float error_model = 0;  ///< distance of the surface from the original
  float off_model = 0;    ///< the larger of error_model and the appearance error
  /// Threshold at which this part would be selected: the cut's for exact parts, lower for finer stand-ins,
  /// max(threshold, error_px) otherwise.
  float threshold_px = 0;
  ModelBox box = {};  ///< the node's
};

/// A texture tile to draw. The cache shares the image, which never changes; equal tiles share one image.
struct ResidentTile {
  TileKey key;
  std::shared_ptr<const TileImage> image;
};

/// A node outside the view whose mesh is missing.
struct LeftOut {
  NodeKey node;
  ModelBox box;
};

/// A coarser part that replaces the cut's parts below its node as soon as a camera sees one of the nodes left
/// out there: see shownParts(). Ranges index the vectors of the cut and exclude their end.
struct Fallback {
  CutPart part;
  uint32_t first_part = 0, end_part = 0;          ///< parts below the node
  uint32_t first_left_out = 0, end_left_out = 0;  ///< left-out nodes that have no nearer fallback
  uint32_t first_nested = 0;                      ///< fallbacks below the node: from here up to this one
};

/// Parts that cover the model exactly once, depth first, by octant. The refiner publishes cuts; they are
/// immutable, and the renderer reads them on another thread. Parts without triangles are omitted. Until the
/// cut has settled, parts outside the view and its margin may be missing too: call shownParts() to draw the
/// cut for a camera that has moved.
struct Cut {
  View view;               ///< view of the refinement
  float threshold_px = 1;  ///< largest error that the refinement allowed
  uint64_t build = 0;      ///< Model::build()
  std::vector<CutPart> parts;
  std::vector<LeftOut> left_out;    ///< missing parts, all outside the view; each has a fallback
  std::vector<Fallback> fallbacks;  ///< depth first, children before parents
  uint64_t triangles = 0;
  uint64_t blob_bytes = 0;   ///< encoded size of the meshes and tiles in use
  uint64_t drawn_bytes = 0;  ///< GPU memory of the parts and fallbacks: see drawnBytes()
  float max_error_px = 0;    ///< largest error of the visible parts
  float refinable_px = 0;    ///< largest error among visible parts that have a finer version
  /// No visible part exceeds the threshold, except leaves at their original triangles, and every tile that
  /// fits the texture budget is resident or lost.
  bool converged = false;
  uint64_t lost_tiles = 0;  ///< visible tiles that cannot be loaded; a lost texture set counts as one
  std::shared_ptr<const TextureSet> textures;  ///< null: no textures, or not loaded yet
  std::vector<ResidentTile> tiles;             ///< by key, coarse levels first
};

/// The threshold as an angle, independent of the picture size. Multiply by focalPx() of another view to get
/// pixels there.
inline double thresholdRad(const Cut& cut) noexcept { return cut.threshold_px / focalPx(cut.view); }

constexpr float kFarOffFactor = 2;

/// Returns true if a visible part that can be refined has more than twice the requested error.
/// @param cut  null: nothing is resident yet, which returns true.
inline bool isFarOff(const Cut* cut, float threshold_px) noexcept {
  return cut == nullptr || cut->refinable_px > kFarOffFactor * threshold_px;
}

/// Parts and fallbacks of a cut share one numbering: parts first, then fallbacks.
inline size_t partCount(const Cut& cut) noexcept { return cut.parts.size() + cut.fallbacks.size(); }
/// @param number  below partCount().
inline const CutPart& partOf(const Cut& cut, size_t number) noexcept {
  return number < cut.parts.size() ? cut.parts[number] : cut.fallbacks[number - cut.parts.size()].part;
}

/// Selects the parts to draw for any camera: the cut's parts, but a fallback for its whole region where the
/// camera sees a node that is left out. The result covers every visible place exactly once.
/// @return numbers for partOf(), depth first.
std::vector<uint32_t> shownParts(const Cut& cut, const View& view);

/// Returns the largest projected error of the drawn parts that a camera sees; 0 if it sees none.
/// @param shown  numbers for partOf().
float shownErrorPx(const Cut& cut, std::span<const uint32_t> shown, const View& view) noexcept;

/// Counts the left-out nodes that a camera sees and no drawn part covers.
/// @param shown  numbers for partOf().
size_t countHoles(const Cut& cut, std::span<const uint32_t> shown, const View& view);

/// The cuts of one model for all of its views, which share meshes. Immutable.
struct ViewCuts {
  std::vector<std::shared_ptr<const Cut>> cuts;  ///< by view
  /// Union of the cuts: with one view its cut; with several, all parts and fallbacks as parts, each mesh
  /// once, with the textures, the sum of triangles and the largest error.
  std::shared_ptr<const Cut> all;
};

/// Builds the union of several cuts: see ViewCuts::all.
/// @param cuts  at least one; all of the same build and threshold.
std::shared_ptr<Cut> gatherMeshes(std::span<const std::shared_ptr<const Cut>> cuts);

}  // namespace lode::core
