#include "common/image/tile_image.h"

#include <cstdlib>
#include <random>

#include <gtest/gtest.h>

#include "common/codec/texture_set.h"
#include "common/error.h"
#include "common/image/jpeg_decoder.h"
#include "tests/support/jpeg_files.h"
#include "tests/support/texture_images.h"

namespace lode {
namespace {

using Bytes = std::vector<std::byte>;
using test::jpegOf;
using test::jpegScans;

/// Makes a smooth image, which JPEG hardly changes.
TileImage gradient(uint32_t width, uint32_t height) {
  TileImage image{{width, height}, {}, {}};
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x)
      image.texels.emplace_back(255 * x / width, 255 * y / height, 90, 255);
  return image;
}

int worstDifference(const TileImage& a, const TileImage& b) {
  if (a.size != b.size || a.texels.size() != b.texels.size()) return 256;
  int worst = 0;
  for (size_t i = 0; i < a.texels.size(); ++i)
    for (int c = 0; c < 4; ++c) worst = std::max(worst, std::abs(a.texels[i][c] - b.texels[i][c]));
  return worst;
}

TEST(TileImage, decodesAWebpWithoutLoss) {
  TileImage image = gradient(300, 200);
  for (size_t i = 0; i < image.texels.size(); i += 7) image.texels[i].a = 128;
  EXPECT_EQ(decodeTile(test::webpOf(image), {300, 200}), image);
}

TEST(TileImage, decodesAJpegNearlyWithoutLoss) {
  const TileImage image = gradient(512, 130);
  EXPECT_LE(worstDifference(decodeTile(jpegOf(image), {512, 130}), image), 6);
  EXPECT_LE(worstDifference(decodeTile(jpegOf(image, true), {512, 130}), image), 6);
}

TEST(TileImage, decodesAGreyJpegToGrey) {
  const TileImage decoded = decodeTile(jpegOf(gradient(64, 64), false, 1), {64, 64});
  for (const glm::u8vec4 texel : decoded.texels)
    ASSERT_TRUE(texel.r == texel.g && texel.g == texel.b && texel.a == 255);
}

TEST(TileImage, isRefusedIfItsSizeIsNotTheAnnouncedOne) {
  for (const Bytes& file : {test::webpOf(gradient(100, 60)), jpegOf(gradient(100, 60))}) {
    EXPECT_NO_THROW(decodeTile(file, {100, 60}));
    EXPECT_THROW(decodeTile(file, {60, 100}), Error);
    EXPECT_THROW(decodeTile(file, {100, 61}), Error);
    EXPECT_THROW(decodeTile(file, {99, 60}), Error);
  }
}

TEST(TileImage, isRefusedAboveTheLimitsBeforeItIsRead) {
  EXPECT_THROW(decodeTile(jpegOf(gradient(kTilePx + 1, 8)), {kTilePx + 1, 8}), Error);
  EXPECT_THROW(decodeTile(jpegOf(gradient(8, 8)), {0, 8}), Error);
  Bytes padded = test::webpOf(gradient(8, 8));
  padded.resize(kMaxTileBytes + 1);
  EXPECT_THROW(decodeTile(padded, {8, 8}), Error);
}

TEST(TileImage, isRefusedIfNeitherJpegNorWebp) {
  EXPECT_THROW(decodeTile({}, {8, 8}), Error);
  EXPECT_THROW(decodeTile(Bytes(100), {8, 8}), Error);
  Bytes magic{std::byte{0xff}, std::byte{0xd8}, std::byte{0xff}};
  EXPECT_THROW(decodeTile(magic, {8, 8}), Error);
}

TEST(TileImage, isRefusedIfTruncated) {
  for (const Bytes& file :
       {test::webpOf(gradient(64, 64)), jpegOf(gradient(64, 64)), jpegOf(gradient(64, 64), true)})
    for (size_t length = 0; length < file.size() - 2; length += 1 + file.size() / 50)
      EXPECT_THROW(decodeTile(std::span(file).first(length), {64, 64}), Error) << length;
}

TEST(TileImage, isRefusedOrOfTheRightSizeIfDamaged) {
  std::mt19937 random(11);
  for (const Bytes& file :
       {test::webpOf(gradient(64, 64)), jpegOf(gradient(64, 64)), jpegOf(gradient(64, 64), true)})
    for (int round = 0; round < 300; ++round) {
      Bytes damaged = file;
      for (int i = 0; i < 3; ++i) damaged[random() % damaged.size()] = static_cast<std::byte>(random());
      try {
        EXPECT_EQ(decodeTile(damaged, {64, 64}).texels.size(), 64u * 64u);
      } catch (const Error&) {
      }
    }
}

TEST(TileImage, isRefusedIfItIsAJpegWithTooManyScans) {
  const TileImage image = gradient(64, 64);
  EXPECT_NO_THROW(decodeTile(jpegOf(image, false, 3, jpegScans(kMaxJpegScans)), {64, 64}));
  try {
    decodeTile(jpegOf(image, false, 3, jpegScans(kMaxJpegScans + 1)), {64, 64});
    FAIL() << "it was decoded";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("scans"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace lode
