#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "client/core/textures/texture_footprint.h"
#include "client/core/textures/tile.h"
#include "client/core/view/view.h"
#include "common/codec/texture_set.h"
#include "common/image/tile_image.h"

namespace lode::core {

/// One part of a cut with its texture footprint.
struct TexturedPart {
  const TextureFootprint* footprint = nullptr;
  double distance_model = 0;  ///< distance between the eye and the nearest point of the part
  bool visible = true;
};

/// A tile that a view needs.
struct WantedTile {
  TileKey key;
  bool visible = true;
  /// Size in pixels of the next coarser level's texels, which are shown while this tile is missing. For a
  /// tile of the coarsest level, the priority is the size of the whole image in pixels, because no texture is
  /// shown while the tile is missing. The priority is at most the larger side of the picture.
  float priority_px = 0;

  bool operator==(const WantedTile&) const = default;
};

/// Returns the bytes that the budget counts for an image, in memory and on the GPU alike: the size of a
/// square of RGBA texels whose side is the next power of two, because the renderer packs images into such
/// squares on the GPU.
uint64_t tileRoomBytes(glm::uvec2 image_size) noexcept;
/// Returns the bytes that the budget counts for a tile, including the tail if its level is the coarsest.
uint64_t tileRoomBytes(const TextureSet& set, const TileKey& key);
/// Returns the bytes that the budget counts for a decoded tile, including its tail.
uint64_t tileRoomBytes(const TileImage& image) noexcept;
constexpr uint32_t kLeastTileCellPx = 32;  ///< smallest side of the square that tileRoomBytes() counts

/// Selects the tiles that a view of a cut needs. For each level 0 tile that visible parts use, selects the
/// coarsest level whose texels are at most max(threshold_px, 1) pixels wide at the nearest point of the part,
/// and all coarser levels. For parts outside the view, selects the coarsest level. Sorts tiles of coarsest
/// levels first, then visible tiles before others, then by descending priority, then by key. Coarser tiles
/// have higher priorities. Deterministic.
/// @param threshold_px  threshold of the refinement.
std::vector<WantedTile> wantTiles(const TextureSet& set, std::span<const TexturedPart> parts,
                                  const View& view, float threshold_px);

/// Returns how many of the leading tiles fit the budget. Stops at the first tile that does not fit, so that
/// no fine tile displaces a coarser tile.
size_t countFitting(const TextureSet& set, std::span<const WantedTile> wanted, uint64_t budget_bytes);

}  // namespace lode::core
