#include "common/codec/texture_set.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "common/error.h"
#include "common/printable.h"

namespace lode {
namespace {

constexpr uint8_t kSetVersion = 1;
constexpr size_t kTileRefBytes = 24;

[[noreturn]] void refuseSet(const std::string& why) {
  throw Error(ErrorCode::kFormat, "damaged texture set: " + why + "; fetch it again or rebuild the store");
}

void requireAtMost(uint64_t value, uint64_t limit, const char* what) {
  if (value > limit)
    throw Error(ErrorCode::kLimit, "texture set: " + std::to_string(value) + " " + what + ", the limit is " +
                                       std::to_string(limit));
}

class SetWriter {
 public:
  std::vector<std::byte> take() { return std::move(bytes_); }

  void fixed(uint64_t value, int width) {
    for (int i = 0; i < width; ++i) bytes_.push_back(static_cast<std::byte>(value >> 8 * i & 255));
  }
  void raw(std::span<const std::byte> bytes) { bytes_.insert(bytes_.end(), bytes.begin(), bytes.end()); }

 private:
  std::vector<std::byte> bytes_;
};

class SetReader {
 public:
  explicit SetReader(std::span<const std::byte> bytes) : bytes_(bytes) {}
  size_t left() const noexcept { return bytes_.size(); }

  std::span<const std::byte> take(size_t length) {
    if (length > bytes_.size()) refuseSet("it is cut off");
    const auto taken = bytes_.first(length);
    bytes_ = bytes_.subspan(length);
    return taken;
  }
  uint64_t fixed(size_t width) {
    uint64_t value = 0;
    const auto bytes = take(width);
    for (size_t i = 0; i < width; ++i) value |= std::to_integer<uint64_t>(bytes[i]) << 8 * i;
    return value;
  }
  uint32_t u32() { return static_cast<uint32_t>(fixed(4)); }

 private:
  std::span<const std::byte> bytes_;
};

void checkScale(const TextureSet& set) {
  for (int axis = 0; axis < 2; ++axis)
    if (!(std::abs(set.uv_origin[axis]) <= kMaxUvOrigin))
      refuseSet("the coordinates' origin is out of range");
  if (std::abs(int64_t{set.uv_scale_exponent}) > kMaxUvExponent)
    refuseSet("the coordinates' scale is out of range");
}

void checkTexture(const Texture& texture) {
  requireAtMost(texture.name.size(), kMaxTextureNameBytes, "bytes in a texture's name");
  if (!isPrintableUtf8(texture.name)) refuseSet("a texture's name is not printable UTF-8");
  requireAtMost(std::max(texture.width, texture.height), kMaxTextureEdgePx, "texels along a texture");
  if ((texture.width == 0) != (texture.height == 0)) refuseSet("a texture has a width or a height only");
}

void checkTile(const BlobRef& tile) {
  if (!tile || tile.bytes == 0) refuseSet("a tile is missing");
  requireAtMost(tile.bytes, kMaxTileBytes, "bytes in a tile");
}

BlobRef readTile(SetReader& in) {
  BlobRef tile;
  tile.number = in.u32();
  tile.bytes = in.u32();
  const auto name = in.take(tile.digest.bytes.size());
  std::copy(name.begin(), name.end(), tile.digest.bytes.begin());
  checkTile(tile);
  return tile;
}

uint32_t inTiles(uint32_t texels) { return (texels + kTileInnerPx - 1) / kTileInnerPx; }

/// @param tiles  number of tiles of all textures read so far; grows by the tiles of this texture.
Texture readTexture(SetReader& in, uint64_t& tiles) {
  Texture texture;
  const auto name = in.take(in.fixed(2));
  texture.name.assign(reinterpret_cast<const char*>(name.data()), name.size());
  texture.width = in.u32();
  texture.height = in.u32();
  checkTexture(texture);
  const uint64_t own = tileCount(texture);
  requireAtMost(tiles += own, kMaxTextureTiles, "tiles");
  if (own * kTileRefBytes > in.left()) refuseSet("it is cut off");
  texture.tiles.reserve(own);
  for (uint64_t i = 0; i < own; ++i) texture.tiles.push_back(readTile(in));
  return texture;
}

}  // namespace

uint32_t levelCount(const Texture& texture) {
  if (texture.width == 0 || texture.height == 0) return 0;
  uint32_t levels = 1;
  while (glm::any(glm::greaterThan(levelSize(texture, levels - 1), glm::uvec2(kTileInnerPx)))) ++levels;
  return levels;
}

glm::uvec2 levelSize(const Texture& texture, uint32_t level) {
  const auto halved = [level](uint32_t texels) {
    return std::max(1u, static_cast<uint32_t>((uint64_t{texels} + (uint64_t{1} << level) - 1) >> level));
  };
  return {halved(texture.width), halved(texture.height)};
}

uint32_t tilesAcross(const Texture& texture, uint32_t level) { return inTiles(levelSize(texture, level).x); }
uint32_t tilesDown(const Texture& texture, uint32_t level) { return inTiles(levelSize(texture, level).y); }

uint64_t tileCount(const Texture& texture) {
  uint64_t tiles = 0;
  for (uint32_t level = levelCount(texture); level-- > 0;)
    tiles += uint64_t{tilesAcross(texture, level)} * tilesDown(texture, level);
  return tiles;
}

size_t tileIndex(const Texture& texture, uint32_t level, uint32_t x, uint32_t y) {
  size_t before = 0;
  for (uint32_t coarser = levelCount(texture); --coarser > level;)
    before += size_t{tilesAcross(texture, coarser)} * tilesDown(texture, coarser);
  return before + size_t{y} * tilesAcross(texture, level) + x;
}

glm::uvec2 tileInnerSize(const Texture& texture, uint32_t level, uint32_t x, uint32_t y) {
  return glm::min(levelSize(texture, level) - kTileInnerPx * glm::uvec2(x, y), glm::uvec2(kTileInnerPx));
}

double uvStep(const TextureSet& set) { return std::ldexp(1.0, set.uv_scale_exponent - 16); }

std::optional<TileKind> tileKind(std::span<const std::byte> tile) noexcept {
  const auto has = [tile](size_t at, std::string_view magic) {
    return tile.size() >= at + magic.size() && std::memcmp(tile.data() + at, magic.data(), magic.size()) == 0;
  };
  if (has(0, "\xff\xd8\xff")) return TileKind::kJpeg;
  if (has(0, "RIFF") && has(8, "WEBP")) return TileKind::kWebp;
  return std::nullopt;
}

std::vector<std::byte> encodeTextureSet(const TextureSet& set) {
  checkScale(set);
  requireAtMost(set.textures.size(), kMaxTextures, "textures");
  SetWriter out;
  out.fixed(kSetVersion, 1);
  for (int axis = 0; axis < 2; ++axis) out.fixed(std::bit_cast<uint64_t>(set.uv_origin[axis]), 8);
  out.fixed(static_cast<uint32_t>(set.uv_scale_exponent), 4);
  out.fixed(set.textures.size(), 4);
  uint64_t tiles = 0;
  for (const Texture& texture : set.textures) {
    checkTexture(texture);
    requireAtMost(tiles += texture.tiles.size(), kMaxTextureTiles, "tiles");
    if (texture.tiles.size() != tileCount(texture)) refuseSet("a texture's tiles do not fit its size");
    out.fixed(texture.name.size(), 2);
    out.raw(std::as_bytes(std::span(texture.name)));
    out.fixed(texture.width, 4);
    out.fixed(texture.height, 4);
    for (const BlobRef& tile : texture.tiles) {
      checkTile(tile);
      out.fixed(tile.number, 4);
      out.fixed(tile.bytes, 4);
      out.raw(tile.digest.bytes);
    }
  }
  return out.take();
}

TextureSet decodeTextureSet(std::span<const std::byte> bytes) {
  requireAtMost(bytes.size(), kMaxTextureSetBytes, "bytes");
  SetReader in(bytes);
  if (in.fixed(1) != kSetVersion) refuseSet("its version is unknown");
  TextureSet set;
  for (int axis = 0; axis < 2; ++axis) set.uv_origin[axis] = std::bit_cast<double>(in.fixed(8));
  set.uv_scale_exponent = std::bit_cast<int32_t>(in.u32());
  checkScale(set);
  const uint32_t textures = in.u32();
  requireAtMost(textures, kMaxTextures, "textures");
  set.textures.reserve(textures);
  uint64_t tiles = 0;
  for (uint32_t i = 0; i < textures; ++i) set.textures.push_back(readTexture(in, tiles));
  if (in.left() != 0) refuseSet("bytes follow its end");
  return set;
}

}  // namespace lode
