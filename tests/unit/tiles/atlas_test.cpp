#include "server/tiles/atlas.h"

#include <random>

#include <gtest/gtest.h>

#include "server/tiles/texel_fill.h"
#include "tests/unit/tiles/textured_store.h"

namespace lode::tiles {
namespace {

AtlasPiece piece(glm::ivec2 first, glm::ivec2 size, uint32_t level = 0) {
  return {.level = level, .first = first, .end = first + size};
}

TEST(AtlasPieces, areJoinedIfTheyOverlapAndJoiningAddsNoTexels) {
  std::vector<AtlasPiece> pieces{piece({0, 0}, {10, 10}), piece({5, 0}, {10, 10}), piece({200, 0}, {4, 4}),
                                 piece({202, 1}, {1, 1}), piece({9, 9}, {30, 30}), piece({2, 2}, {4, 4}, 1)};
  const std::vector<uint32_t> owners = joinPieces(pieces);
  EXPECT_EQ(pieces.size(), 4u);
  EXPECT_EQ(owners[0], owners[1]);
  EXPECT_EQ(owners[2], owners[3]);
  EXPECT_NE(owners[0], owners[4]);  // a box around both would have more texels
  EXPECT_NE(owners[0], owners[5]);  // pieces of different levels stay separate
}

TEST(AtlasPieces, lieInThePieceThatOwnsThem) {
  std::mt19937 random(5);
  std::vector<AtlasPiece> given;
  for (int i = 0; i < 400; ++i)
    given.push_back(
        piece({random() % 300, random() % 300}, {1 + random() % 40, 1 + random() % 40}, random() % 2));
  std::vector<AtlasPiece> pieces = given;
  const std::vector<uint32_t> owners = joinPieces(pieces);
  EXPECT_LT(pieces.size(), given.size());
  for (size_t i = 0; i < given.size(); ++i) {
    const AtlasPiece& owner = pieces[owners[i]];
    EXPECT_EQ(owner.level, given[i].level);
    EXPECT_TRUE(glm::all(glm::lessThanEqual(owner.first, given[i].first)));
    EXPECT_TRUE(glm::all(glm::greaterThanEqual(owner.end, given[i].end)));
  }
}

TEST(AtlasPieces, havePlacesThatDoNotOverlapInLittleMoreThanTheirArea) {
  for (const uint32_t seed : {1u, 2u, 3u}) {
    std::mt19937 random(seed);
    std::vector<AtlasPiece> pieces;
    uint64_t area = 0;
    for (int i = 0; i < 200; ++i) {
      pieces.push_back(piece({0, 0}, {9 + random() % 60, 9 + random() % 60}));
      area += pieces.back().area();
    }
    const glm::uvec2 size = placePieces(pieces);
    EXPECT_LT(double(size.x) * size.y, 1.25 * double(area)) << seed;
    std::vector<bool> is_taken(size_t{size.x} * size.y);
    for (const AtlasPiece& piece : pieces)
      for (uint32_t y = 0; y < piece.size().y; ++y)
        for (uint32_t x = 0; x < piece.size().x; ++x) {
          ASSERT_LT(piece.place.x + x, size.x);
          ASSERT_LT(piece.place.y + y, size.y);
          const size_t at = size_t{piece.place.y + y} * size.x + piece.place.x + x;
          ASSERT_FALSE(is_taken[at]);
          is_taken[at] = true;
        }
  }
}

TEST(AnAtlas, hasTheTexelsOfItsPiecesAndTheirColoursBetween) {
  const test::TexturedStore store({test::TextureImages(64, 64, test::texelAt)});
  TextureLevels levels(store.reader());
  std::vector<AtlasPiece> pieces{piece({-4, 10}, {20, 30}), piece({40, 0}, {9, 9})};
  const glm::uvec2 size = placePieces(pieces);
  const Atlas atlas = paintAtlas(pieces, size, levels);
  EXPECT_FALSE(atlas.is_clear);
  for (const AtlasPiece& piece : pieces)
    for (const glm::uvec2 at : {glm::uvec2(0, 0), {3, 8}, {8, 8}})
      EXPECT_EQ(atlas.image.at(piece.place.x + at.x, piece.place.y + at.y),
                test::texelAt((piece.first.x + at.x + 64) % 64, piece.first.y + at.y));
  for (const glm::u8vec4& texel : atlas.image.texels) EXPECT_EQ(texel.a, 255);
}

TEST(UnknownTexels, getColoursOfKnownTexelsNearThem) {
  constexpr uint32_t kWidth = 32, kHeight = 9;
  Image image{{kWidth, kHeight}, std::vector<glm::u8vec4>(kWidth * kHeight, glm::u8vec4(0, 0, 0, 0))};
  std::vector<bool> is_known(image.texels.size());
  const auto know = [&](uint32_t x, uint32_t y, glm::u8vec4 colour) {
    image.texels[y * kWidth + x] = colour;
    is_known[y * kWidth + x] = true;
  };
  know(0, 0, {200, 0, 0, 255});
  know(31, 7, {0, 0, 100, 255});
  fillUnknown(image, is_known);
  EXPECT_EQ(image.at(1, 1), glm::u8vec4(200, 0, 0, 0));  // alpha stays
  EXPECT_EQ(image.at(30, 6), glm::u8vec4(0, 0, 100, 0));
  for (const glm::u8vec4& texel : image.texels) EXPECT_GT(texel.r + texel.b, 0);
}

}  // namespace
}  // namespace lode::tiles
