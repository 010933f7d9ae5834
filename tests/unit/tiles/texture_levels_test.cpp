#include "server/tiles/texture_levels.h"

#include <gtest/gtest.h>

#include "tests/unit/tiles/textured_store.h"

namespace lode::tiles {
namespace {

class TextureLevelsOf : public testing::Test {
 protected:
  static constexpr uint32_t kWidth = 1300, kHeight = 700;

  const test::TexturedStore store_{{test::TextureImages(kWidth, kHeight, test::texelAt)}};
  TextureLevels levels_{store_.reader()};
};

TEST_F(TextureLevelsOf, copyTexelsFromAnyPlaceAcrossTiles) {
  for (const glm::ivec2 first : {glm::ivec2(0, 0), {500, 400}, {-7, -3}, {1290, 690}, {-2000, 1500}}) {
    const Image part = levels_.part(0, 0, first, {530, 520});
    for (const glm::uvec2 at : {glm::uvec2(0, 0), {529, 519}, {7, 3}, {8, 300}, {400, 108}}) {
      const auto x = static_cast<uint32_t>((first.x + int(at.x) + 4 * int(kWidth)) % int(kWidth));
      const auto y = static_cast<uint32_t>((first.y + int(at.y) + 4 * int(kHeight)) % int(kHeight));
      EXPECT_EQ(part.at(at.x, at.y), test::texelAt(x, y)) << first.x << " " << at.x << " " << at.y;
    }
  }
}

TEST_F(TextureLevelsOf, goOnBelowTheStoredOnesToOneTexel) {
  EXPECT_EQ(levels_.coarsest(0), 11u);
  EXPECT_EQ(levels_.size(0, 11), glm::uvec2(1));
  const Image stored = levels_.part(0, 2, {0, 0}, levels_.size(0, 2));
  EXPECT_EQ(levels_.part(0, 3, {0, 0}, levels_.size(0, 3)), halved(stored));
  EXPECT_EQ(levels_.part(0, 11, {-3, 5}, {2, 2}).texels.size(), 4u);
}

TEST_F(TextureLevelsOf, tellTheFormatAndAlpha) {
  EXPECT_FALSE(levels_.isJpeg(0));
  EXPECT_FALSE(levels_.mayBeClear(0));
  const test::TexturedStore clear({test::TextureImages(
      8, 8, [](uint32_t x, uint32_t) { return glm::u8vec4(200, 100, 50, x < 4 ? 0 : 255); })});
  EXPECT_TRUE(TextureLevels(clear.reader()).mayBeClear(0));
}

}  // namespace
}  // namespace lode::tiles
