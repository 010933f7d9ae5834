#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "common/codec/blob.h"

/// The textures of a model: how vertices' codes become texture coordinates, and for each image where the
/// tiles of its levels are. One blob of the store; docs/store-format.md has its bytes. All functions are
/// thread safe.
namespace lode {

constexpr uint32_t kTilePx = 512;       ///< longest edge of a tile's image, gutters included
constexpr uint32_t kTileGutterPx = 2;   ///< texels of the neighbourhood on each side of a tile, for filtering
constexpr uint32_t kTileInnerPx = 508;  ///< texels of the level that a tile is there for, at most, each way
static_assert(kTileInnerPx + 2 * kTileGutterPx == kTilePx);

constexpr uint32_t kMaxTextures = 4096;  ///< of one model
constexpr double kMaxUvOrigin = 0x1p60;
constexpr uint32_t kMaxTextureEdgePx = 65536;        ///< of one image
constexpr uint32_t kMaxTextureTiles = 1u << 20;      ///< of one model
constexpr uint32_t kMaxTileBytes = 2u << 20;         ///< of one tile's file
constexpr uint32_t kMaxTextureNameBytes = 1024;      ///< of one texture's name
constexpr uint32_t kMaxTextureSetBytes = 32u << 20;  ///< of an encoded set
constexpr uint32_t kEmptyTextureSetBytes = 25;       ///< of one without textures: coordinates alone
constexpr int32_t kMaxUvExponent = 40;               ///< of uv_scale_exponent, either sign

/// One image as a chain of levels. Level 0 has the full size, level l max(1, ceil(size / 2^l)) texels each
/// way, and the coarsest is the first that fits one tile; each covers the whole image. A tile holds up to
/// kTileInnerPx texels of its level each way, fewer at the right and bottom end, and around them
/// kTileGutterPx more on all sides, those of the level repeated beyond its rim.
struct Texture {
  std::string name;            ///< as the input names it; printable UTF-8
  uint32_t width = 0;          ///< 0, as the height: the image was missing, there are no tiles
  uint32_t height = 0;         ///< texels of level 0
  std::vector<BlobRef> tiles;  ///< coarsest level first, in a level by rows from the image's top

  bool operator==(const Texture&) const = default;
};

/// Texture coordinates are true = uv_origin + code * 2^(uv_scale_exponent - 16), with v = 0 at the image's
/// bottom row's lower edge and v = 1 at the top; outside 0 ... 1 the image repeats. A vertex of material m
/// wears textures[m].
struct TextureSet {
  glm::dvec2 uv_origin{0};
  int32_t uv_scale_exponent = 0;
  std::vector<Texture> textures;

  bool operator==(const TextureSet&) const = default;
};

/// Number of levels; 0 without an image.
uint32_t levelCount(const Texture& texture);
/// Texels of a level, 0 the finest.
glm::uvec2 levelSize(const Texture& texture, uint32_t level);
uint32_t tilesAcross(const Texture& texture, uint32_t level);
uint32_t tilesDown(const Texture& texture, uint32_t level);
/// Of all levels, from width and height alone.
uint64_t tileCount(const Texture& texture);
/// Place in `tiles` of the tile in column x and row y (from the top) of a level.
size_t tileIndex(const Texture& texture, uint32_t level, uint32_t x, uint32_t y);
/// Texels of the level that the tile holds, without gutters.
glm::uvec2 tileInnerSize(const Texture& texture, uint32_t level, uint32_t x, uint32_t y);

/// Distance of neighbouring codes, in true texture coordinates.
double uvStep(const TextureSet& set);

/// A tile is the bytes of an image file as they are.
enum class TileKind : uint8_t { kJpeg, kWebp };
/// By the first bytes; nothing else of the file is looked at.
std::optional<TileKind> tileKind(std::span<const std::byte> tile) noexcept;

/// @throws Error kLimit or kFormat where decodeTextureSet() would refuse the result.
std::vector<std::byte> encodeTextureSet(const TextureSet& set);

/// Validates everything that can be seen without the tiles. @throws Error kFormat or kLimit.
TextureSet decodeTextureSet(std::span<const std::byte> bytes);

}  // namespace lode
