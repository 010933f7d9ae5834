#include "client/app/cli/resident_image.h"

#include <algorithm>
#include <cstddef>

#include "common/image/tile_image.h"

namespace lode::app {

ResidentImage::ResidentImage(const Texture& texture, uint32_t number,
                             std::span<const core::ResidentTile> tiles)
    : texture_(texture), levels_(levelCount(texture)) {
  for (uint32_t level = 0; level < levels_.size(); ++level) {
    levels_[level].across = tilesAcross(texture, level);
    levels_[level].tiles.resize(size_t{levels_[level].across} * tilesDown(texture, level));
  }
  finest_ = levels_.empty() ? 0 : static_cast<uint32_t>(levels_.size() - 1);
  for (const auto& [key, image] : tiles) {
    if (key.texture != number) continue;
    levels_[key.level].tiles[size_t{key.y} * levels_[key.level].across + key.x] = image.get();
    finest_ = std::min(finest_, key.level);
  }
}

bool ResidentImage::isThere() const noexcept {
  return !levels_.empty() && levels_.back().tiles[0] != nullptr;
}

bool ResidentImage::hasAlpha() const {
  const auto isClear = [](const glm::u8vec4& texel) { return texel.a != 255; };
  const auto hasClear = [&](const TileImage* tile) {
    return tile != nullptr && std::ranges::any_of(tile->texels, isClear);
  };
  return std::ranges::any_of(levels_,
                             [&](const Level& level) { return std::ranges::any_of(level.tiles, hasClear); });
}

void ResidentImage::fill(uint32_t y, std::span<glm::u8vec4> row) const { fill(finest_, y, 0, size().x, row); }

/// @param first, end  of the row, in texels of the finest level, as y is.
void ResidentImage::fill(uint32_t level, uint32_t y, uint32_t first, uint32_t end,
                         std::span<glm::u8vec4> row) const {
  const uint32_t shift = level - finest_;
  const uint32_t level_y = y >> shift;
  for (uint32_t x = first; x < end;) {
    const uint32_t column = (x >> shift) / kTileInnerPx;
    const uint32_t next = std::min(end, ((column + 1) * kTileInnerPx) << shift);
    const TileImage* const tile =
        levels_[level].tiles[size_t{level_y / kTileInnerPx} * levels_[level].across + column];
    if (tile == nullptr) {
      fill(level + 1, y, x, next, row);
    } else {
      const glm::u8vec4* const from =
          &tile->texels[size_t{level_y % kTileInnerPx + kTileGutterPx} * tile->size.x + kTileGutterPx];
      for (uint32_t to = x; to < next; ++to) row[to] = from[(to >> shift) - column * kTileInnerPx];
    }
    x = next;
  }
}

}  // namespace lode::app
