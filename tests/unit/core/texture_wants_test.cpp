#include "client/core/textures/texture_wants.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <gtest/gtest.h>

namespace lode::core {
namespace {

constexpr float kTexelsPerModel = 2;

/// Two textures: 2048 x 2048 with 5 x 5 tiles and 4 levels, and 64 x 64 with one tile.
TextureSet twoTextures() {
  TextureSet set;
  set.textures.push_back({"large", 2048, 2048, {}});
  set.textures.push_back({"small", 64, 64, {}});
  return set;
}

TextureFootprint footprintOf(std::initializer_list<glm::uvec2> places, uint32_t texture = 0) {
  TextureFootprint footprint;
  for (const glm::uvec2 place : places)
    footprint.tiles.push_back({texture, place.y, place.x, kTexelsPerModel});
  return footprint;
}

/// Distance at which a pixel covers a number of level 0 texels.
double distanceFor(double texels_px, const View& view) {
  return texels_px / kTexelsPerModel * view.height_px / (2 * std::tan(view.fov_y_rad / 2));
}

std::vector<TileKey> keysOf(const std::vector<WantedTile>& wanted) {
  std::vector<TileKey> keys;
  for (const WantedTile& tile : wanted) keys.push_back(tile.key);
  return keys;
}

const View kPlainView;

TEST(TextureWants, areTheLevelWithATexelPerPixelAndAllCoarserOnes) {
  const TextureFootprint footprint = footprintOf({{4, 4}});
  const auto levels = [&](double texels_px, float threshold_px) {
    std::set<uint32_t> seen;
    const TexturedPart part{&footprint, distanceFor(texels_px, kPlainView), true};
    for (const WantedTile& tile : wantTiles(twoTextures(), {&part, 1}, kPlainView, threshold_px))
      seen.insert(tile.key.level);
    return seen;
  };
  EXPECT_EQ(levels(0.1, 1), (std::set<uint32_t>{0, 1, 2, 3}));
  EXPECT_EQ(levels(1.9, 1), (std::set<uint32_t>{0, 1, 2, 3}));
  EXPECT_EQ(levels(2.1, 1), (std::set<uint32_t>{1, 2, 3}));
  EXPECT_EQ(levels(4.1, 1), (std::set<uint32_t>{2, 3}));
  EXPECT_EQ(levels(1000, 1), (std::set<uint32_t>{3}));
  EXPECT_EQ(levels(1.1, 2), (std::set<uint32_t>{1, 2, 3}));        // a texel may cover two pixels
  EXPECT_EQ(levels(1.9, 0.1f), (std::set<uint32_t>{0, 1, 2, 3}));  // levels finer than pixels are not needed
  EXPECT_EQ(levels(2.1, 0.1f), (std::set<uint32_t>{1, 2, 3}));
}

TEST(TextureWants, coverTheTouchedTilesAtEveryLevel) {
  const TextureFootprint footprint = footprintOf({{0, 0}, {4, 4}});
  const TexturedPart part{&footprint, 0, true};
  std::vector<TileKey> keys = keysOf(wantTiles(twoTextures(), {&part, 1}, kPlainView, 1));
  std::sort(keys.begin(), keys.end());
  const std::vector<TileKey> expected{{3, 0, 0, 0}, {2, 0, 0, 0}, {2, 0, 1, 1}, {1, 0, 0, 0},
                                      {1, 0, 2, 2}, {0, 0, 0, 0}, {0, 0, 4, 4}};
  EXPECT_EQ(keys, expected);
}

TEST(TextureWants, coverAllTilesOfAWholeTexture) {
  TextureFootprint all;
  for (uint32_t y = 0; y < 5; ++y)
    for (uint32_t x = 0; x < 5; ++x) all.tiles.push_back({0, y, x, kTexelsPerModel});
  const TextureFootprint whole{{}, {{0, kTexelsPerModel}}}, corner = footprintOf({{4, 4}});
  const double far_model = distanceFor(2.5, kPlainView), close_model = distanceFor(0.5, kPlainView);
  for (const bool visible : {true, false}) {
    const TexturedPart with_tiles[] = {{&all, far_model, visible}, {&corner, close_model, true}};
    const TexturedPart as_whole[] = {{&whole, far_model, visible}, {&corner, close_model, true}};
    EXPECT_EQ(wantTiles(twoTextures(), as_whole, kPlainView, 1),
              wantTiles(twoTextures(), with_tiles, kPlainView, 1));
  }
}

TEST(TextureWants, comeCoarserBeforeFiner) {
  const TextureFootprint large = footprintOf({{1, 1}, {2, 2}}), small = footprintOf({{0, 0}}, 1);
  const TexturedPart parts[] = {{&large, 3, true}, {&small, 70, true}};
  const std::vector<WantedTile> wanted = wantTiles(twoTextures(), parts, kPlainView, 1);
  for (size_t i = 0; i < wanted.size(); ++i)
    for (size_t j = i + 1; j < wanted.size(); ++j) {
      const bool same = wanted[i].key.texture == wanted[j].key.texture;
      EXPECT_TRUE(!same || wanted[i].key.level >= wanted[j].key.level);
    }
  EXPECT_EQ(wanted[1].key.texture + wanted[0].key.texture, 1u);  // both coarsest levels first
}

TEST(TextureWants, prioritiseByThePixelsOfACoarserTexel) {
  const TextureFootprint footprint = footprintOf({{0, 0}});
  const TexturedPart part{&footprint, distanceFor(1.5, kPlainView), true};
  for (const WantedTile& tile : wantTiles(twoTextures(), {&part, 1}, kPlainView, 1)) {
    const double expected = tile.key.level == 3 ? kPlainView.width_px : std::exp2(tile.key.level + 1) / 1.5;
    EXPECT_NEAR(tile.priority_px, expected, 1e-3 * expected);
  }
}

TEST(TextureWants, followTheNearestOfThePartsThatShareATile) {
  const TextureFootprint footprint = footprintOf({{0, 0}});
  const TexturedPart near_part{&footprint, distanceFor(0.5, kPlainView), true};
  const TexturedPart parts[] = {{&footprint, distanceFor(100, kPlainView), true}, near_part};
  EXPECT_EQ(wantTiles(twoTextures(), parts, kPlainView, 1),
            wantTiles(twoTextures(), {&near_part, 1}, kPlainView, 1));
}

TEST(TextureWants, areTheCoarsestLevelOutsideTheView) {
  const TextureFootprint footprint = footprintOf({{0, 0}, {3, 3}});
  const TexturedPart hidden{&footprint, 0, false};
  const std::vector<WantedTile> wanted = wantTiles(twoTextures(), {&hidden, 1}, kPlainView, 1);
  ASSERT_EQ(wanted.size(), 1u);
  EXPECT_EQ(wanted[0].key.level, 3u);
  EXPECT_FALSE(wanted[0].visible);

  const TexturedPart seen{&footprint, distanceFor(2.5, kPlainView), true};
  const TexturedPart both[] = {hidden, seen};
  EXPECT_EQ(wantTiles(twoTextures(), both, kPlainView, 1),
            wantTiles(twoTextures(), {&seen, 1}, kPlainView, 1));
  const TexturedPart reversed[] = {seen, hidden};
  EXPECT_EQ(wantTiles(twoTextures(), reversed, kPlainView, 1),
            wantTiles(twoTextures(), {&seen, 1}, kPlainView, 1));
}

TEST(TextureWants, includeEveryTileUnderAFinerOneInUnevenLevels) {
  TextureSet set;
  set.textures.push_back({"uneven", 3571, 2049, {}});
  const Texture& texture = set.textures[0];
  for (uint32_t x = 0; x < tilesAcross(texture, 0); ++x) {
    const TextureFootprint footprint = footprintOf({{x, 1}});
    const TexturedPart part{&footprint, 0, true};
    const std::vector<TileKey> keys = keysOf(wantTiles(set, {&part, 1}, kPlainView, 1));
    for (uint32_t texel = x * kTileInnerPx; texel < std::min((x + 1) * kTileInnerPx, texture.width); ++texel)
      for (uint32_t level = 0; level < levelCount(texture); ++level) {
        const glm::dvec2 at((texel + 0.5) / texture.width, (kTileInnerPx * 1.5) / texture.height);
        const glm::uvec2 tile = glm::uvec2(at * glm::dvec2(levelSize(texture, level))) / kTileInnerPx;
        ASSERT_TRUE(std::find(keys.begin(), keys.end(), TileKey{level, 0, tile.y, tile.x}) != keys.end());
      }
  }
}

TEST(TextureWants, areTruncatedToTheBudget) {
  const TextureFootprint large = footprintOf({{0, 0}, {1, 1}, {2, 2}}), small = footprintOf({{0, 0}}, 1);
  const TexturedPart parts[] = {{&large, 0, true}, {&small, 0, true}};
  const TextureSet set = twoTextures();
  const std::vector<WantedTile> wanted = wantTiles(set, parts, kPlainView, 1);
  uint64_t all_bytes = 0;
  for (const WantedTile& tile : wanted) all_bytes += tileRoomBytes(set, tile.key);
  EXPECT_EQ(countFitting(set, wanted, all_bytes), wanted.size());
  EXPECT_EQ(countFitting(set, wanted, all_bytes - 1), wanted.size() - 1);
  EXPECT_EQ(countFitting(set, wanted, 0), 0u);
}

TEST(TileRoom, includesTheTailOfACoarsestLevel) {
  const TextureSet set = twoTextures();
  EXPECT_EQ(tileRoomBytes(set, {0, 0, 1, 1}), tileRoomBytes({512, 512}));
  uint64_t expected = 0;
  for (const uint32_t edge : {128, 64, 32, 32, 32, 32, 32})
    expected += edge * edge * 4;  // sides of 68 to 5 texels
  EXPECT_EQ(tileRoomBytes(set, {0, 1, 0, 0}), expected);
}

TEST(TileRoom, isTheMemoryOfASquareOnTheGpu) {
  EXPECT_EQ(tileRoomBytes({512, 5}), 512u * 512u * 4u);
  EXPECT_EQ(tileRoomBytes({200, 256}), 256u * 256u * 4u);
  EXPECT_EQ(tileRoomBytes({5, 5}), kLeastTileCellPx * kLeastTileCellPx * 4u);
}

}  // namespace
}  // namespace lode::core
