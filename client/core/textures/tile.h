#pragma once

#include <compare>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "common/codec/texture_set.h"
#include "common/image/tile_image.h"

namespace lode::core {

/// Identifies one tile of a model's textures. Coarser levels sort first.
struct TileKey {
  uint32_t level = 0;    ///< number of the mip level; 0 is the finest
  uint32_t texture = 0;  ///< index of the texture in the texture set
  uint32_t y = 0, x = 0;

  bool operator==(const TileKey&) const = default;
  friend constexpr std::strong_ordering operator<=>(const TileKey& a, const TileKey& b) noexcept {
    if (a.level != b.level) return b.level <=> a.level;
    if (a.texture != b.texture) return a.texture <=> b.texture;
    if (a.y != b.y) return a.y <=> b.y;
    return a.x <=> b.x;
  }
};

/// Returns the blob of a tile. @param key  key of a tile of the set.
inline const BlobRef& tileBlob(const TextureSet& set, const TileKey& key) {
  const Texture& texture = set.textures[key.texture];
  return texture.tiles[tileIndex(texture, key.level, key.x, key.y)];
}

/// Returns the size of a tile's image, including gutters.
inline glm::uvec2 tileImageSize(const TextureSet& set, const TileKey& key) {
  return tileInnerSize(set.textures[key.texture], key.level, key.x, key.y) + 2 * kTileGutterPx;
}

// The coarsest stored level of a texture is the first level that fits into one tile. Seen from far away, this
// level would alias. The client therefore computes the remaining mip levels, down to one texel; these levels
// are the tail. Each level of the tail is an image with its own gutters.

/// Returns the sizes of the tail's images, finest first. @param coarsest  size of the coarsest stored level.
/// All sizes include gutters.
std::vector<glm::uvec2> tailSizes(glm::uvec2 coarsest);

/// Computes the tail into coarsest.coarser. Each level has half the width and height of the level before it:
/// see halved() in common/image/image.h.
void makeTail(TileImage& coarsest);

}  // namespace lode::core
