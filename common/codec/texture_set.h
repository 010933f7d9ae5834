#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "common/codec/blob.h"
#include "common/mesh.h"

/// The textures of a model: the mapping from quantized to true texture coordinates, and references to the
/// tiles of each image. A texture set is one blob of the store (docs/store-format.md). All functions are
/// thread safe.
namespace lode {

constexpr uint32_t kTilePx = 512;  ///< longest edge of a tile's image, with gutters
/// Width of the border that repeats texels of the neighbouring tiles, for filtering.
constexpr uint32_t kTileGutterPx = 2;
constexpr uint32_t kTileInnerPx = 508;  ///< largest edge of a tile without gutters
static_assert(kTileInnerPx + 2 * kTileGutterPx == kTilePx);

constexpr uint32_t kMaxTextures = 4096;  ///< number of textures of one model
constexpr double kMaxUvOrigin = 0x1p60;
constexpr uint32_t kMaxTextureEdgePx = 65536;        ///< longest edge of one image
constexpr uint32_t kMaxTextureTiles = 1u << 20;      ///< number of tiles of one model
constexpr uint32_t kMaxTileBytes = 2u << 20;         ///< size of one tile's file
constexpr uint32_t kMaxTextureNameBytes = 1024;      ///< length of one texture's name
constexpr uint32_t kMaxTextureSetBytes = 32u << 20;  ///< size of an encoded set
constexpr uint32_t kEmptyTextureSetBytes = 25;       ///< size of an encoded set without textures
constexpr int32_t kMaxUvExponent = 40;               ///< largest absolute value of uv_scale_exponent

/// One image as a chain of levels. Level l has max(1, ceil(size / 2^l)) texels along each axis. The coarsest
/// level is the first level that fits one tile. A tile contains up to kTileInnerPx texels of its level along
/// each axis, fewer at the right and bottom edges. A gutter of kTileGutterPx texels surrounds these texels
/// and repeats the texels of neighbouring tiles; at the border of a level, it repeats texels from the
/// opposite border.
struct Texture {
  std::string name;            ///< name in the input; printable UTF-8
  uint32_t width = 0;          ///< texels of level 0 per row; 0 if the image was missing
  uint32_t height = 0;         ///< rows of level 0; 0 if the image was missing
  std::vector<BlobRef> tiles;  ///< all tiles, coarsest level first; within a level, row by row from the top

  bool operator==(const Texture&) const = default;
};

/// True texture coordinates are uv_origin + code * 2^(uv_scale_exponent - 16). v is 0 at the bottom edge of
/// the image and 1 at the top. The image repeats outside 0..1. A vertex with material m uses textures[m].
struct TextureSet {
  glm::dvec2 uv_origin{0};
  int32_t uv_scale_exponent = 0;
  std::vector<Texture> textures;

  bool operator==(const TextureSet&) const = default;
};

/// Returns the number of levels, or 0 if the image was missing.
uint32_t levelCount(const Texture& texture);
/// Returns the size of a level in texels; level 0 is the finest.
glm::uvec2 levelSize(const Texture& texture, uint32_t level);
uint32_t tilesAcross(const Texture& texture, uint32_t level);
uint32_t tilesDown(const Texture& texture, uint32_t level);
/// Returns the number of tiles of all levels, computed from width and height alone.
uint64_t tileCount(const Texture& texture);
/// Returns the index in `tiles` of the tile in column x and row y (from the top) of a level.
size_t tileIndex(const Texture& texture, uint32_t level, uint32_t x, uint32_t y);
/// Returns the size of a tile in texels, without gutters.
glm::uvec2 tileInnerSize(const Texture& texture, uint32_t level, uint32_t x, uint32_t y);

/// Returns the distance between neighbouring codes in true texture coordinates.
double uvStep(const TextureSet& set);

/// Returns the true texture coordinates of a vertex. v is 0 at the bottom of the image.
inline glm::dvec2 trueTextureCoordinates(const TextureSet& set, const VertexAttributes& vertex) {
  return set.uv_origin + glm::dvec2(vertex.texture) * uvStep(set);
}

/// File format of a tile. A tile is a complete image file.
enum class TileKind : uint8_t { kJpeg, kWebp };
/// Detects the format from the first bytes of a tile. Returns nothing if they match no known format.
std::optional<TileKind> tileKind(std::span<const std::byte> tile) noexcept;

/// Encodes a set. @throws Error kLimit or kFormat if decodeTextureSet() would refuse the result.
std::vector<std::byte> encodeTextureSet(const TextureSet& set);

/// Decodes a set and validates everything except the contents of tiles. @throws Error kFormat or kLimit.
TextureSet decodeTextureSet(std::span<const std::byte> bytes);

}  // namespace lode
