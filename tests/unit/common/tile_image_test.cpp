#include "common/tile_image.h"

#include <cstdio>
#include <cstdlib>
#include <random>

#include <gtest/gtest.h>
#include <jpeglib.h>

#include "common/error.h"
#include "common/texture_set.h"
#include "tests/support/texture_images.h"

namespace lode {
namespace {

using Bytes = std::vector<std::byte>;

/// A smooth image, so that JPEG hardly changes it.
TileImage gradient(uint32_t width, uint32_t height) {
  TileImage image{{width, height}, {}, {}};
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x)
      image.texels.emplace_back(255 * x / width, 255 * y / height, 90, 255);
  return image;
}

Bytes jpegOf(const TileImage& image, bool progressive = false, int components = 3,
             std::span<const jpeg_scan_info> scans = {}) {
  jpeg_compress_struct encoder{};
  jpeg_error_mgr errors{};
  encoder.err = jpeg_std_error(&errors);
  jpeg_create_compress(&encoder);
  unsigned char* file = nullptr;
  unsigned long bytes = 0;
  jpeg_mem_dest(&encoder, &file, &bytes);
  encoder.image_width = image.size.x;
  encoder.image_height = image.size.y;
  encoder.input_components = components == 1 ? 1 : 4;
  encoder.in_color_space = components == 1 ? JCS_GRAYSCALE : JCS_EXT_RGBA;
  jpeg_set_defaults(&encoder);
  jpeg_set_quality(&encoder, 95, TRUE);
  if (progressive) jpeg_simple_progression(&encoder);
  if (!scans.empty()) {
    encoder.scan_info = scans.data();
    encoder.num_scans = static_cast<int>(scans.size());
  }
  jpeg_start_compress(&encoder, TRUE);
  std::vector<unsigned char> row;
  while (encoder.next_scanline < encoder.image_height) {
    row.clear();
    for (uint32_t x = 0; x < image.size.x; ++x) {
      const glm::u8vec4 texel = image.texels[encoder.next_scanline * image.size.x + x];
      for (int c = 0; c < encoder.input_components; ++c) row.push_back(texel[c]);
    }
    JSAMPROW rows = row.data();
    jpeg_write_scanlines(&encoder, &rows, 1);
  }
  jpeg_finish_compress(&encoder);
  const auto* const begin = reinterpret_cast<const std::byte*>(file);
  Bytes result(begin, begin + bytes);
  jpeg_destroy_compress(&encoder);
  std::free(file);
  return result;
}

int worstDifference(const TileImage& a, const TileImage& b) {
  if (a.size != b.size || a.texels.size() != b.texels.size()) return 256;
  int worst = 0;
  for (size_t i = 0; i < a.texels.size(); ++i)
    for (int c = 0; c < 4; ++c) worst = std::max(worst, std::abs(a.texels[i][c] - b.texels[i][c]));
  return worst;
}

TEST(TileImage, isWhatAWebpHoldsWithoutLoss) {
  TileImage image = gradient(300, 200);
  for (size_t i = 0; i < image.texels.size(); i += 7) image.texels[i].a = 128;
  EXPECT_EQ(decodeTile(test::webpOf(image), {300, 200}), image);
}

TEST(TileImage, isNearlyWhatAJpegHolds) {
  const TileImage image = gradient(512, 130);
  EXPECT_LE(worstDifference(decodeTile(jpegOf(image), {512, 130}), image), 6);
  EXPECT_LE(worstDifference(decodeTile(jpegOf(image, true), {512, 130}), image), 6);
}

TEST(TileImage, ofAGreyJpegIsGrey) {
  const TileImage decoded = decodeTile(jpegOf(gradient(64, 64), false, 1), {64, 64});
  for (const glm::u8vec4 texel : decoded.texels)
    ASSERT_TRUE(texel.r == texel.g && texel.g == texel.b && texel.a == 255);
}

TEST(TileImage, ofAnotherSizeThanAnnouncedIsRefused) {
  for (const Bytes& file : {test::webpOf(gradient(100, 60)), jpegOf(gradient(100, 60))}) {
    EXPECT_NO_THROW(decodeTile(file, {100, 60}));
    EXPECT_THROW(decodeTile(file, {60, 100}), Error);
    EXPECT_THROW(decodeTile(file, {100, 61}), Error);
    EXPECT_THROW(decodeTile(file, {99, 60}), Error);
  }
}

TEST(TileImage, beyondTheLimitsIsRefusedBeforeItIsLookedAt) {
  EXPECT_THROW(decodeTile(jpegOf(gradient(kTilePx + 1, 8)), {kTilePx + 1, 8}), Error);
  EXPECT_THROW(decodeTile(jpegOf(gradient(8, 8)), {0, 8}), Error);
  Bytes padded = test::webpOf(gradient(8, 8));
  padded.resize(kMaxTileBytes + 1);
  EXPECT_THROW(decodeTile(padded, {8, 8}), Error);
}

TEST(TileImage, thatIsNeitherJpegNorWebpIsRefused) {
  EXPECT_THROW(decodeTile({}, {8, 8}), Error);
  EXPECT_THROW(decodeTile(Bytes(100), {8, 8}), Error);
  Bytes magic{std::byte{0xff}, std::byte{0xd8}, std::byte{0xff}};
  EXPECT_THROW(decodeTile(magic, {8, 8}), Error);
}

TEST(TileImage, thatIsCutOffIsRefused) {
  for (const Bytes& file :
       {test::webpOf(gradient(64, 64)), jpegOf(gradient(64, 64)), jpegOf(gradient(64, 64), true)})
    for (size_t length = 0; length < file.size() - 2; length += 1 + file.size() / 50)
      EXPECT_THROW(decodeTile(std::span(file).first(length), {64, 64}), Error) << length;
}

TEST(TileImage, ofDamagedBytesIsRefusedOrOfTheRightSize) {
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

/// One scan for each coefficient of each component, as the format allows.
std::vector<jpeg_scan_info> manyScans(int coefficients) {
  std::vector<jpeg_scan_info> scans{{3, {0, 1, 2}, 0, 0, 0, 0}};
  for (int component = 0; component < 3; ++component)
    for (int i = 1; i < coefficients; ++i) scans.push_back({1, {component}, i, i, 0, 0});
  return scans;
}

TEST(TileImage, ofAJpegWithTooManyScansIsRefused) {
  const TileImage image = gradient(64, 64);
  EXPECT_NO_THROW(decodeTile(jpegOf(image, false, 3, manyScans(20)), {64, 64}));
  try {
    decodeTile(jpegOf(image, false, 3, manyScans(64)), {64, 64});
    FAIL() << "it was decoded";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("scans"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace lode
