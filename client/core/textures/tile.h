#pragma once

#include <compare>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "common/codec/texture_set.h"
#include "common/image/tile_image.h"

namespace lode::core {

/// Names one tile of a model's textures. Coarser levels come first in their order.
struct TileKey {
  uint32_t level = 0;    ///< 0 is the finest
  uint32_t texture = 0;  ///< its number in the set
  uint32_t y = 0, x = 0;

  bool operator==(const TileKey&) const = default;
  friend constexpr std::strong_ordering operator<=>(const TileKey& a, const TileKey& b) noexcept {
    if (a.level != b.level) return b.level <=> a.level;
    if (a.texture != b.texture) return a.texture <=> b.texture;
    if (a.y != b.y) return a.y <=> b.y;
    return a.x <=> b.x;
  }
};

/// The blob of a tile. @param key  of a tile that the set has.
inline const BlobRef& tileBlob(const TextureSet& set, const TileKey& key) {
  const Texture& texture = set.textures[key.texture];
  return texture.tiles[tileIndex(texture, key.level, key.x, key.y)];
}

/// Size of a tile's image, gutters included.
inline glm::uvec2 tileImageSize(const TextureSet& set, const TileKey& key) {
  return tileInnerSize(set.textures[key.texture], key.level, key.x, key.y) + 2 * kTileGutterPx;
}

/// A texture's stored levels end with the first that fits one tile; seen from afar that one would sparkle.
/// The tail is what a chain of levels goes on with, down to one texel: made by the client, each in an image
/// with gutters of its own.

/// Sizes of the tail's images, gutters included, finest first. @param coarsest  of the coarsest stored level,
/// gutters included.
std::vector<glm::uvec2> tailSizes(glm::uvec2 coarsest);

/// Fills coarsest.coarser from its texels: each level the finer one halved (common/image/image.h).
void makeTail(TileImage& coarsest);

}  // namespace lode::core
