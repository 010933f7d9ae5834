#include "client/core/textures/tile.h"

#include <gtest/gtest.h>

#include "common/codec/texture_set.h"

namespace lode::core {
namespace {

/// An image whose gutters repeat it, as in a coarsest level.
TileImage imageOf(uint32_t width, uint32_t height, const std::vector<glm::u8vec4>& texels) {
  TileImage image{{width + 2 * kTileGutterPx, height + 2 * kTileGutterPx}, {}, {}};
  for (uint32_t y = 0; y < image.size.y; ++y)
    for (uint32_t x = 0; x < image.size.x; ++x)
      image.texels.push_back(texels[(y + height * kTileGutterPx - kTileGutterPx) % height * width +
                                    (x + width * kTileGutterPx - kTileGutterPx) % width]);
  return image;
}

const glm::u8vec4 kWhite(255), kBlack(0, 0, 0, 255), kClear(200, 0, 0, 0);

TEST(TileTail, endsWithOneTexel) {
  EXPECT_EQ(tailSizes({512, 12}),
            (std::vector<glm::uvec2>{
                {258, 8}, {131, 6}, {68, 5}, {36, 5}, {20, 5}, {12, 5}, {8, 5}, {6, 5}, {5, 5}}));
  EXPECT_TRUE(tailSizes({5, 5}).empty());
}

TEST(TileTail, hasTheSizesThatAreAnnounced) {
  TileImage image = imageOf(37, 5, std::vector<glm::u8vec4>(37 * 5, kWhite));
  makeTail(image);
  std::vector<glm::uvec2> sizes;
  for (const TileImage& coarser : image.coarser) {
    sizes.push_back(coarser.size);
    EXPECT_EQ(coarser.texels, std::vector<glm::u8vec4>(size_t{coarser.size.x} * coarser.size.y, kWhite));
  }
  EXPECT_EQ(sizes, tailSizes(image.size));
}

TEST(TileTail, isTheMeanInLinearLight) {
  TileImage image = imageOf(2, 2, {kWhite, kBlack, kBlack, kWhite});
  makeTail(image);
  ASSERT_EQ(image.coarser.size(), 1u);
  for (const glm::u8vec4 texel : image.coarser[0].texels) EXPECT_EQ(texel, glm::u8vec4(188, 188, 188, 255));
}

TEST(TileTail, ignoresTheColourOfClearTexels) {
  TileImage image = imageOf(2, 1, {kWhite, kClear});
  makeTail(image);
  EXPECT_EQ(image.coarser.at(0).texels[0], glm::u8vec4(255, 255, 255, 128));
}

TEST(TileTail, repeatsTheImageInItsGutters) {
  std::vector<glm::u8vec4> texels;
  for (int i = 0; i < 64; ++i) texels.emplace_back(4 * i, 0, 0, 255);
  TileImage image = imageOf(8, 8, texels);
  makeTail(image);
  const TileImage& half = image.coarser.at(0);
  for (uint32_t y = 0; y + 4 < half.size.y; ++y)
    for (uint32_t x = 0; x + 4 < half.size.x; ++x) {
      EXPECT_EQ(half.texels[y * half.size.x + x], half.texels[y * half.size.x + x + 4]);
      EXPECT_EQ(half.texels[y * half.size.x + x], half.texels[(y + 4) * half.size.x + x]);
    }
}

}  // namespace
}  // namespace lode::core
