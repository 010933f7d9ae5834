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

/// One drawn part of the model. The mesh is shared with the cache and never changes.
struct CutPart {
  NodeKey node;
  uint32_t lod = 0;
  bool visible = true;  ///< false: outside the view, held for completeness or as a fallback
  float error_px = 0;   ///< projected error at refinement
  std::shared_ptr<const Mesh> mesh;
  float error_model = 0;  ///< how far its surface lies from the original one
  float off_model = 0;    ///< the larger of that and of its lost detail: error_px is of it
  /// Whose cut would have it: of what is wanted and seen that of the cut that it is made for, of a finer
  /// stand-in less, of a coarser one, a fallback or what is not seen as much as its error, if that is more.
  float threshold_px = 0;
  ModelBox box = {};  ///< of its node
};

/// A tile of a texture that may be drawn. The image is shared with the cache and never changes; tiles that
/// are equal share one.
struct ResidentTile {
  TileKey key;
  std::shared_ptr<const TileImage> image;
};

/// A place where a cut has no part yet.
struct LeftOut {
  NodeKey node;
  ModelBox box;
};

/// A part above places that are left out: to be drawn instead of the cut's parts below it as soon as a camera
/// sees one of those places. See shownParts().
struct Fallback {
  CutPart part;
  uint32_t first_part = 0, end_part = 0;          ///< those of the cut below it
  uint32_t first_left_out = 0, end_left_out = 0;  ///< what it is for: no other fallback is nearer
  uint32_t first_nested = 0;                      ///< fallbacks below it: from here up to itself
};

/// What covers the model exactly once (design: cut), depth first, by octant; published by the refiner,
/// immutable, read by the renderer on another thread. Parts without triangles are left out, and until it has
/// settled parts that cannot be seen from the view, nor if it turned a little: shownParts() says what to draw
/// for a camera that is elsewhere meanwhile.
struct Cut {
  View view;               ///< for which it was refined,
  float threshold_px = 1;  ///< and down to which error
  uint64_t build = 0;      ///< of the model: see Model::build()
  std::vector<CutPart> parts;
  std::vector<LeftOut> left_out;    ///< parts that are not there: none in the view, a fallback for each
  std::vector<Fallback> fallbacks;  ///< depth first, each after those below it
  uint64_t triangles = 0;
  uint64_t blob_bytes = 0;   ///< of the blobs that it is made of
  uint64_t drawn_bytes = 0;  ///< that its meshes and its fallbacks' take where they are drawn
  float max_error_px = 0;    ///< of the visible parts
  float refinable_px = 0;    ///< of those of them for which something finer can be had
  bool converged = false;    ///< nothing visible is above the threshold, but leaves at their original
                             ///< triangles, and every tile that the memory allows for textures is there
  uint64_t lost_tiles = 0;   ///< but for these, which the view sees and which cannot be had; the set is one
  std::shared_ptr<const TextureSet> textures;  ///< null: the model has none, or they are not there yet
  std::vector<ResidentTile> tiles;             ///< by key, coarse levels first
};

/// Its threshold as the eye sees it, whatever the pixels of the picture that it was made for: times
/// focalPx(), those of another.
inline double thresholdRad(const Cut& cut) noexcept { return cut.threshold_px / focalPx(cut.view); }

constexpr float kFarOffFactor = 2;

/// Whether more than twice the error that was asked for is seen where something finer is to come.
/// @param cut  null: there is none yet.
inline bool isFarOff(const Cut* cut, float threshold_px) noexcept {
  return cut == nullptr || cut->refinable_px > kFarOffFactor * threshold_px;
}

/// How many numbers partOf() knows: first the cut's parts, then those of its fallbacks.
inline size_t partCount(const Cut& cut) noexcept { return cut.parts.size() + cut.fallbacks.size(); }
inline const CutPart& partOf(const Cut& cut, size_t number) noexcept {
  return number < cut.parts.size() ? cut.parts[number] : cut.fallbacks[number - cut.parts.size()].part;
}

/// What to draw of a cut for a camera, wherever it has gone since: the cut's parts, but where it sees a place
/// that is left out the fallback, for all of its region. It covers what the camera sees, no place twice.
/// @return numbers for partOf(), depth first.
std::vector<uint32_t> shownParts(const Cut& cut, const View& view);

/// The largest error in the picture of a camera, wherever it has gone since, of what is drawn of a cut; 0 if
/// it sees none of it. @param shown  numbers for partOf().
float shownErrorPx(const Cut& cut, std::span<const uint32_t> shown, const View& view) noexcept;

/// Places that are left out of a cut, that a camera sees, and that nothing drawn covers.
/// @param shown  numbers for partOf() of what is drawn.
size_t countHoles(const Cut& cut, std::span<const uint32_t> shown, const View& view);

/// The cuts of one model for all of its views, which share meshes. Immutable, as cuts are.
struct ViewCuts {
  std::vector<std::shared_ptr<const Cut>> cuts;  ///< by view
  /// All that they are drawn from: of one view its cut; of several, their parts and fallbacks as parts, each
  /// mesh once, with the textures, their triangles added up, and the largest error.
  std::shared_ptr<const Cut> all;
};

/// @param cuts  of one build and threshold, one at least.
std::shared_ptr<Cut> gatherMeshes(std::span<const std::shared_ptr<const Cut>> cuts);

}  // namespace lode::core
