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
  double distance_model = 0;  ///< eye to the nearest point of the part
  bool visible = true;
};

/// A tile that a view needs.
struct WantedTile {
  TileKey key;
  bool visible = true;
  /// Pixels per shown texel while the tile is missing and all coarser ones are resident. For a coarsest
  /// level, without which the texture is absent: pixels of the whole image. At most the larger side of the
  /// picture.
  float priority_px = 0;

  bool operator==(const WantedTile&) const = default;
};

/// Size that an image takes in the texture budget, in memory and on the GPU alike: RGBA texels of a square
/// whose side is the next power of two, as the GPU packs them.
uint64_t tileRoomBytes(glm::uvec2 image_size) noexcept;
/// The same for a tile, including the tail of a coarsest level.
uint64_t tileRoomBytes(const TextureSet& set, const TileKey& key);
/// The same for a decoded tile.
uint64_t tileRoomBytes(const TileImage& image) noexcept;
constexpr uint32_t kLeastTileCellPx = 32;  ///< smallest side that counts

/// Selects the tiles that a view of a cut needs. For each level 0 tile that visible parts use: the level
/// whose texels cover at most the threshold (at least one pixel) at the nearest point of the part, and all
/// coarser levels. For parts outside the view: the coarsest level. Order: coarsest levels, then visible
/// tiles, then by priority, which is higher for coarser tiles, then by key. Deterministic.
/// @param threshold_px  threshold of the refinement.
std::vector<WantedTile> wantTiles(const TextureSet& set, std::span<const TexturedPart> parts,
                                  const View& view, float threshold_px);

/// Returns how many of the leading tiles fit the budget. Stops at the first that does not fit, so that no
/// fine tile displaces a coarser one.
size_t countFitting(const TextureSet& set, std::span<const WantedTile> wanted, uint64_t budget_bytes);

}  // namespace lode::core
