#include "server/tiles/texture_levels.h"

#include <algorithm>
#include <bit>
#include <string>

#include "common/codec/texture_set.h"
#include "common/error.h"

namespace lode::tiles {
namespace {

/// Largest number of decoded tiles in memory, of at most 1 MiB each.
constexpr size_t kMostTiles = 32;

uint32_t floorMod(int64_t value, uint32_t size) {
  const int64_t rest = value % size;
  return static_cast<uint32_t>(rest < 0 ? rest + size : rest);
}

}  // namespace

uint32_t TextureLevels::coarsest(uint32_t texture) const {
  const Texture& image = textureOf(texture);
  return static_cast<uint32_t>(std::bit_width(std::max(image.width, image.height) - 1));
}

glm::uvec2 TextureLevels::size(uint32_t texture, uint32_t level) const {
  return levelSize(textureOf(texture), level);
}

std::vector<std::byte> TextureLevels::coarsestTile(uint32_t texture) const {
  return reader_.readBlob(textureOf(texture).tiles.front().number);
}

bool TextureLevels::mayBeClear(uint32_t texture) const { return tileMayBeClear(coarsestTile(texture)); }

bool TextureLevels::isJpeg(uint32_t texture) const {
  return tileKind(coarsestTile(texture)) == TileKind::kJpeg;
}

const TileImage& TextureLevels::tile(uint32_t texture, size_t number, glm::uvec2 inner_size) {
  const auto found = tiles_.find({texture, number});
  if (found != tiles_.end()) return found->second;
  if (tiles_.size() == kMostTiles) tiles_.clear();
  const uint32_t blob = textureOf(texture).tiles[number].number;
  try {
    return tiles_[{texture, number}] = decodeTile(reader_.readBlob(blob), inner_size + 2 * kTileGutterPx);
  } catch (const Error& error) {
    tiles_.erase({texture, number});
    throw Error(error.code(),
                reader_.path().string() + ": texture " + std::to_string(texture) + ": " + error.what());
  }
}

const Image& TextureLevels::computed(uint32_t texture, uint32_t level) {
  const auto found = computed_.find({texture, level});
  if (found != computed_.end()) return found->second;
  const uint32_t stored = levelCount(textureOf(texture)) - 1;
  Image image = level == stored + 1 ? halved(part(texture, stored, {0, 0}, size(texture, stored)))
                                    : halved(computed(texture, level - 1));
  return computed_[{texture, level}] = std::move(image);
}

Image TextureLevels::part(uint32_t texture, uint32_t level, glm::ivec2 first, glm::uvec2 part_size) {
  const Texture& image = textureOf(texture);
  if (level >= levelCount(image)) return cutOut(computed(texture, level), first, part_size);
  const glm::uvec2 whole = levelSize(image, level);
  Image result{part_size, std::vector<glm::u8vec4>(size_t{part_size.x} * part_size.y)};
  // Copy the part in rectangles, each from one tile.
  for (uint32_t y = 0; y < part_size.y;) {
    const uint32_t from_y = floorMod(int64_t{first.y} + y, whole.y);
    const uint32_t row = from_y / kTileInnerPx, within_y = from_y % kTileInnerPx;
    uint32_t rows = 0;
    for (uint32_t x = 0; x < part_size.x;) {
      const uint32_t from_x = floorMod(int64_t{first.x} + x, whole.x);
      const uint32_t column = from_x / kTileInnerPx, within_x = from_x % kTileInnerPx;
      const glm::uvec2 inner = tileInnerSize(image, level, column, row);
      const TileImage& from = tile(texture, tileIndex(image, level, column, row), inner);
      rows = std::min(inner.y - within_y, part_size.y - y);
      const uint32_t columns = std::min(inner.x - within_x, part_size.x - x);
      for (uint32_t k = 0; k < rows; ++k)
        std::copy_n(from.texels.data() + size_t{within_y + kTileGutterPx + k} * from.size.x + within_x +
                        kTileGutterPx,
                    columns, result.texels.data() + size_t{y + k} * part_size.x + x);
      x += columns;
    }
    y += rows;
  }
  return result;
}

}  // namespace lode::tiles
