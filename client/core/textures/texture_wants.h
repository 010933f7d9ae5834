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

/// One part of a cut, as its textures are looked at.
struct TexturedPart {
  const TextureFootprint* footprint = nullptr;
  double distance_model = 0;  ///< eye to the nearest point of the part
  bool visible = true;
};

/// A tile that a view needs.
struct WantedTile {
  TileKey key;
  bool visible = true;
  /// Pixels that a texel shown there covers while the tile is missing and all coarser ones are there; of a
  /// coarsest level, without which there is no texture at all, the pixels that the whole image covers. Never
  /// more than the picture has in a row or column.
  float priority_px = 0;

  bool operator==(const WantedTile&) const = default;
};

/// Room that an image of this size takes in the budget of textures, in memory and on the GPU alike: RGBA
/// texels of a square with the next power of two for an edge, as the GPU packs them.
uint64_t tileRoomBytes(glm::uvec2 image_size) noexcept;
/// The same for a tile, with its tail if it is of the coarsest level.
uint64_t tileRoomBytes(const TextureSet& set, const TileKey& key);
/// The same for a decoded tile.
uint64_t tileRoomBytes(const TileImage& image) noexcept;
constexpr uint32_t kLeastTileCellPx = 32;  ///< smaller images take as much as one of this edge

/// The tiles that a view of a cut needs: of each tile of level 0 that visible parts touch, the level where
/// a texel covers at most the threshold, one pixel at least, at the nearest point of the part, and all
/// coarser ones; of parts outside the view the coarsest level. Coarsest levels come first, then what is in
/// the picture; among them best first, coarser ones before finer ones, ties by key.
/// A function of its arguments alone. @param threshold_px  of the refinement.
std::vector<WantedTile> wantTiles(const TextureSet& set, std::span<const TexturedPart> parts,
                                  const View& view, float threshold_px);

/// How many of the tiles, from the first, fit into the budget. What comes after the first that does not fit
/// is left out, so that no fine tile takes the room of a coarser one.
size_t countFitting(const TextureSet& set, std::span<const WantedTile> wanted, uint64_t budget_bytes);

}  // namespace lode::core
