#include "common/image/image.h"

#include <cmath>

#include <gtest/gtest.h>

namespace lode {
namespace {

TEST(Halved, keepsAPlainColour) {
  for (const glm::uvec2 size : {glm::uvec2(8, 8), {7, 5}, {1, 9}, {3, 1}, {2, 2}}) {
    const Image image{size, std::vector<glm::u8vec4>(size_t{size.x} * size.y, {17, 200, 3, 99})};
    const Image half = halved(image);
    EXPECT_EQ(half.size, (size + 1u) / 2u);
    for (const glm::u8vec4 texel : half.texels) EXPECT_EQ(texel, glm::u8vec4(17, 200, 3, 99));
  }
}

TEST(Halved, keepsEverySrgbValue) {
  for (unsigned value = 0; value < 256; ++value) {
    const auto byte = static_cast<uint8_t>(value);
    const Image image{{2, 2}, std::vector<glm::u8vec4>(4, {byte, byte, byte, 255})};
    EXPECT_EQ(halved(image).texels[0], glm::u8vec4(byte, byte, byte, 255));
  }
}

TEST(Halved, mixesInLinearLight) {
  const Image image{{2, 1}, {{0, 0, 0, 255}, {255, 255, 255, 255}}};
  EXPECT_EQ(halved(image).texels[0], glm::u8vec4(188, 188, 188, 255));
}

TEST(Halved, takesTheLightOfEveryValueFromTheFormulaOfSrgb) {
  const auto lightOf = [](double srgb) {
    return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
  };
  for (unsigned value = 0; value < 256; ++value) {  // averaged with a black texel
    const auto byte = static_cast<uint8_t>(value);
    const Image image{{2, 1}, {{0, 0, 0, 255}, {byte, byte, byte, 255}}};
    const double light = lightOf(value / 255.0) / 2, found = halved(image).texels[0].r;
    EXPECT_GE(light, lightOf((found - 0.51) / 255)) << value;
    EXPECT_LE(light, lightOf((found + 0.51) / 255)) << value;
  }
}

TEST(Halved, weighsColoursByTheirAlpha) {
  const Image image{{2, 1}, {{255, 0, 0, 255}, {0, 255, 0, 0}}};
  EXPECT_EQ(halved(image).texels[0], glm::u8vec4(255, 0, 0, 128));
}

TEST(Halved, dividesOddSizesEvenly) {
  // Each coarser texel covers 1.5 of the three texels, so that the first has 2/3 of the light.
  const Image image{{3, 1}, {{255, 255, 255, 255}, {0, 0, 0, 255}, {0, 0, 0, 255}}};
  const Image half = halved(image);
  ASSERT_EQ(half.size, glm::uvec2(2, 1));
  EXPECT_EQ(half.texels[0].r, 213);  // sRGB of 2/3
  EXPECT_EQ(half.texels[1].r, 0);
}

TEST(CutOut, repeatsThePictureBeyondItsBoundaries) {
  const Image image{{2, 2}, {{0, 0, 0, 1}, {1, 0, 0, 1}, {0, 1, 0, 1}, {1, 1, 0, 1}}};
  const Image part = cutOut(image, {-3, -2}, {6, 5});
  ASSERT_EQ(part.size, glm::uvec2(6, 5));
  for (uint32_t y = 0; y < 5; ++y)
    for (uint32_t x = 0; x < 6; ++x) EXPECT_EQ(part.at(x, y), glm::u8vec4((x + 1) % 2, y % 2, 0, 1));
}

TEST(Srgb, survivesTheConversionToLinearLight) {
  for (int byte = 0; byte < 256; ++byte) {
    const auto srgb = static_cast<uint8_t>(byte);
    EXPECT_EQ(srgbOf(linearOf(srgb)), srgb);
  }
}

TEST(Srgb, hasHalfOfTheLightWellAboveTheMiddleOfItsBytes) {
  EXPECT_EQ(srgbOf(0.5), 188);
  EXPECT_EQ(srgbOf(2), 255);
  EXPECT_EQ(srgbOf(-1), 0);
}

}  // namespace
}  // namespace lode
