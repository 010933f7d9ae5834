#include "server/ingest/textures/image_decoder.h"

#include <random>

#include <gtest/gtest.h>

#include "common/image/jpeg_decoder.h"
#include "server/store/tile_encoder.h"
#include "tests/support/bytes.h"
#include "tests/support/jpeg_files.h"
#include "tests/unit/ingest/textures/image_files.h"

namespace lode::ingest {
namespace {

using test::kMega;
using test::makePhoto;
using test::pngHeader;
using test::pngOf;

Image decoded(std::span<const std::byte> file, uint64_t memory_bytes = 64 * kMega) {
  std::string damage;
  return decodeImage(file, memory_bytes, damage);
}

void expectRefused(std::span<const std::byte> file, const std::string& why,
                   ErrorCode code = ErrorCode::kInput, uint64_t memory_bytes = 64 * kMega) {
  try {
    decoded(file, memory_bytes);
    ADD_FAILURE() << "accepted, not refused for: " << why;
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code);
    EXPECT_NE(std::string(error.what()).find(why), std::string::npos) << error.what();
  }
}

double meanDifference(const Image& a, const Image& b) {
  double sum = 0;
  for (size_t i = 0; i < a.texels.size(); ++i)
    for (int c = 0; c < 4; ++c) sum += std::abs(int{a.texels[i][c]} - int{b.texels[i][c]});
  return sum / (4.0 * static_cast<double>(a.texels.size()));
}

TEST(DecodeImage, readsPngJpegAndWebp) {
  const Image opaque = makePhoto(70, 50), clear = makePhoto(70, 50, true);
  EXPECT_EQ(decoded(pngOf(opaque)), opaque);
  EXPECT_EQ(decoded(pngOf(clear)), clear);
  EXPECT_EQ(decoded(store::encodeTile(clear, store::TileCodec::kLossless)), clear);
  const Image photo = decoded(store::encodeTile(opaque, store::TileCodec::kJpeg));
  ASSERT_EQ(photo.size, opaque.size);
  EXPECT_LT(meanDifference(photo, opaque), 1.5);
}

TEST(DecodeImage, takesAPngOf16BitsAsTheSameColoursAsOneOf8) {
  const Image image = makePhoto(70, 50, true);
  EXPECT_LT(meanDifference(decoded(test::png16Of(image)), image), 0.5);
}

TEST(DecodeImage, namesACmykJpegByItsHeader) {
  const std::vector<std::byte> file = test::jpegOf(makePhoto(64, 64), false, 4);
  EXPECT_THROW(readImageHeader(file), Error);
  expectRefused(file, "is a CMYK JPEG; convert it to RGB");
}

TEST(DecodeImage, countsTheTablesOfAWebpInTheMemoryThatItTakes) {
  const Image small = makePhoto(256, 256, true);
  const std::vector<std::byte> file = store::encodeTile(small, store::TileCodec::kLossless);
  constexpr uint64_t kTables = 640'000;  // as many as a larger picture was seen to have
  EXPECT_GE(readImageHeader(file).working_bytes, 2 * small.texels.size() * sizeof(glm::u8vec4) + kTables);
  expectRefused(file, "raise --memory", ErrorCode::kLimit, kMega);
}

TEST(DecodeImage, refusesAFileThatIsNoImage) {
  expectRefused({}, "not a JPEG, PNG or WebP");
  const std::string text = "GIF89a and so on";
  expectRefused(std::as_bytes(std::span(text)), "convert it");
}

TEST(DecodeImage, survivesFilesCutOffAnywhere) {
  const Image image = makePhoto(40, 30);
  for (const auto& file : {pngOf(image), store::encodeTile(image, store::TileCodec::kJpeg),
                           store::encodeTile(image, store::TileCodec::kWebp),
                           store::encodeTile(image, store::TileCodec::kLossless)})
    for (size_t length = 0; length < file.size(); length += 7) {
      std::string damage;
      try {
        const Image part = decodeImage(std::span(file).first(length), 64 * kMega, damage);
        EXPECT_TRUE(!damage.empty() || part == decoded(file)) << length << " bytes are said to be whole";
      } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::kInput);
      }
    }
}

TEST(DecodeImage, refusesDamageAnywhereOrGivesASizeThatTheHeaderSays) {
  std::mt19937 random(5);
  const Image image = makePhoto(40, 30);
  for (const auto& whole : {pngOf(image), store::encodeTile(image, store::TileCodec::kJpeg),
                            store::encodeTile(image, store::TileCodec::kWebp),
                            store::encodeTile(image, store::TileCodec::kLossless)}) {
    int refused = 0;
    for (int i = 0; i < 500; ++i) {
      std::vector<std::byte> file = whole;
      file[random() % file.size()] ^= static_cast<std::byte>(1 + random() % 255);
      try {
        const Image shown = decoded(file);
        const ImageHeader header = readImageHeader(file);
        EXPECT_EQ(shown.size, glm::uvec2(header.width, header.height));
        EXPECT_EQ(shown.texels.size(), size_t{shown.size.x} * shown.size.y);
      } catch (const Error& error) {
        EXPECT_TRUE(error.code() == ErrorCode::kInput || error.code() == ErrorCode::kLimit) << error.what();
        ++refused;
      }
    }
    EXPECT_GT(refused, 0);
    EXPECT_LT(refused, 500);
  }
}

TEST(DecodeImage, refusesSizesAboveTheLimitBeforeItTakesMemory) {
  expectRefused(pngHeader(65537, 1), "the limit is 65536");
  expectRefused(pngHeader(1, 65537), "the limit is 65536");
}

TEST(DecodeImage, refusesImagesAboveTheMemoryBeforeItAllocates) {
  expectRefused(pngHeader(65536, 65536), "raise --memory", ErrorCode::kLimit);
  expectRefused(pngOf(makePhoto(100, 100)), "raise --memory", ErrorCode::kLimit, 50000);
}

TEST(DecodeImage, saysWhenAJpegIsDamagedButShown) {
  std::vector<std::byte> file = store::encodeTile(makePhoto(200, 200), store::TileCodec::kJpeg);
  file.resize(file.size() / 2);
  std::string damage;
  EXPECT_EQ(decodeImage(file, 64 * kMega, damage).size, glm::uvec2(200, 200));
  EXPECT_NE(damage, "");
}

TEST(DecodeImage, refusesAJpegWithMoreScansThanTheLimit) {
  const Image image = makePhoto(64, 64);
  EXPECT_EQ(decoded(test::jpegOf(image, false, 3, test::jpegScans(kMaxJpegScans))).size, image.size);
  expectRefused(test::jpegOf(image, false, 3, test::jpegScans(kMaxJpegScans + 1)), "more than 64 scans");
}

TEST(ChooseCodec, goesByColoursAndAlpha) {
  EXPECT_EQ(store::chooseCodec(makePhoto(100, 100)), store::TileCodec::kJpeg);
  EXPECT_EQ(store::chooseCodec(makePhoto(100, 100, true)), store::TileCodec::kWebp);
  Image drawing = makePhoto(100, 100);
  for (glm::u8vec4& texel : drawing.texels) texel &= glm::u8vec4(0xc0);
  EXPECT_EQ(store::chooseCodec(drawing), store::TileCodec::kLossless);
}

TEST(EncodeTile, keepsAlphaAndColoursCloseToTheTexels) {
  const Image clear = makePhoto(128, 100, true);
  const Image back = decoded(store::encodeTile(clear, store::TileCodec::kWebp));
  EXPECT_LT(meanDifference(back, clear), 2.5);
  for (size_t i = 0; i < back.texels.size(); ++i) EXPECT_EQ(back.texels[i].a, clear.texels[i].a);
}

TEST(EncodeTile, staysBelowTheLimitOfATileForNoise) {
  std::mt19937 random(1);
  Image noise{{512, 512}, {}};
  for (int i = 0; i < 512 * 512; ++i)
    noise.texels.emplace_back(random() & 255, random() & 255, random() & 255, random() & 255);
  for (const store::TileCodec codec :
       {store::TileCodec::kJpeg, store::TileCodec::kWebp, store::TileCodec::kLossless})
    EXPECT_LE(store::encodeTile(noise, codec).size(), size_t{2} << 20);
}

}  // namespace
}  // namespace lode::ingest
