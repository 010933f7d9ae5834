#include "client/app/cli/resident_image.h"

#include <memory>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/texture_images.h"

namespace lode::app {
namespace {

constexpr uint32_t kWidth = 1100, kHeight = 520;

/// Every texel tells where it is.
test::TextureImages gradient(uint8_t alpha = 255) {
  return test::TextureImages(kWidth, kHeight, [alpha](uint32_t x, uint32_t y) {
    return glm::u8vec4(x & 255, y & 255, x >> 8, alpha);
  });
}

using Key = std::tuple<uint32_t, uint32_t, uint32_t>;  // level, x, y

std::vector<core::ResidentTile> tilesOf(const test::TextureImages& images, const std::vector<Key>& keys) {
  std::vector<core::ResidentTile> tiles;
  for (const auto& [level, x, y] : keys)
    tiles.push_back({{level, 0, y, x}, std::make_shared<const TileImage>(images.tile(level, x, y))});
  return tiles;
}

std::vector<Key> allOfLevel(const Texture& texture, uint32_t level) {
  std::vector<Key> keys;
  for (uint32_t y = 0; y < tilesDown(texture, level); ++y)
    for (uint32_t x = 0; x < tilesAcross(texture, level); ++x) keys.emplace_back(level, x, y);
  return keys;
}

std::vector<glm::u8vec4> rowOf(const ResidentImage& image, uint32_t y) {
  std::vector<glm::u8vec4> row(image.size().x);
  image.fill(y, row);
  return row;
}

TEST(ResidentImage, isNotThereWithoutItsCoarsestLevel) {
  const test::TextureImages images = gradient();
  EXPECT_FALSE(ResidentImage(images.texture(), 0, tilesOf(images, {{0, 1, 0}})).isThere());
}

TEST(ResidentImage, leavesOutTilesOfOtherTextures) {
  const test::TextureImages images = gradient();
  EXPECT_FALSE(ResidentImage(images.texture(), 1, tilesOf(images, {{2, 0, 0}})).isThere());
}

TEST(ResidentImage, hasTheSizeOfTheFinestLevelThatHasATile) {
  const test::TextureImages images = gradient();
  const auto coarse = tilesOf(images, {{2, 0, 0}, {1, 0, 0}});
  EXPECT_EQ(ResidentImage(images.texture(), 0, coarse).size(), glm::uvec2(550, 260));
}

TEST(ResidentImage, isTheOriginalWhereAllIsThere) {
  const test::TextureImages images = gradient();
  std::vector<Key> keys = allOfLevel(images.texture(), 0);
  keys.emplace_back(2, 0, 0);
  const auto tiles = tilesOf(images, keys);
  const ResidentImage image(images.texture(), 0, tiles);
  ASSERT_EQ(image.size(), glm::uvec2(kWidth, kHeight));
  for (uint32_t y = 0; y < kHeight; ++y) {
    const auto row = rowOf(image, y);
    for (uint32_t x = 0; x < kWidth; ++x) ASSERT_EQ(row[x], glm::u8vec4(x & 255, y & 255, x >> 8, 255));
  }
}

TEST(ResidentImage, repeatsCoarserTexelsWhereTheFinestLevelLacksATile) {
  const test::TextureImages images = gradient();
  const auto tiles = tilesOf(images, {{0, 1, 0}, {2, 0, 0}});
  const ResidentImage image(images.texture(), 0, tiles);
  const TileImage coarsest = images.tile(2, 0, 0);
  const auto row = rowOf(image, 301);
  for (uint32_t x = 0; x < kWidth; ++x) {
    const bool is_fine = x / kTileInnerPx == 1;
    const glm::u8vec4 coarse = coarsest.texels[size_t{301 / 4 + kTileGutterPx} * coarsest.size.x + x / 4 + 2];
    ASSERT_EQ(row[x], is_fine ? glm::u8vec4(x & 255, 301 & 255, x >> 8, 255) : coarse) << x;
  }
}

TEST(ResidentImage, hasAlphaWhereATexelIsNotOpaque) {
  const test::TextureImages opaque = gradient(), clear = gradient(200);
  const auto opaque_tiles = tilesOf(opaque, {{2, 0, 0}}), clear_tiles = tilesOf(clear, {{2, 0, 0}});
  EXPECT_FALSE(ResidentImage(opaque.texture(), 0, opaque_tiles).hasAlpha());
  EXPECT_TRUE(ResidentImage(clear.texture(), 0, clear_tiles).hasAlpha());
}

}  // namespace
}  // namespace lode::app
