#include "common/codec/texture_set.h"

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "common/error.h"

namespace lode {
namespace {

Texture sized(uint32_t width, uint32_t height) {
  Texture texture;
  texture.width = width;
  texture.height = height;
  return texture;
}

Texture withTiles(const std::string& name, uint32_t width, uint32_t height) {
  Texture texture = sized(width, height);
  texture.name = name;
  const auto tiles = static_cast<uint32_t>(tileCount(texture));
  for (uint32_t i = 0; i < tiles; ++i) {
    BlobRef tile{i + 1, 1000 + i, {}};
    tile.digest.bytes[0] = static_cast<std::byte>(i);
    texture.tiles.push_back(tile);
  }
  return texture;
}

TextureSet sampleSet() {
  TextureSet set;
  set.uv_origin = {-0.5, 1e6};
  set.uv_scale_exponent = -3;
  set.textures = {withTiles("bark 1.png", 1200, 600), withTiles("missing.jpg", 0, 0),
                  withTiles("Blätter/π.png", 1, 508)};
  return set;
}

std::string refusal(const std::function<void()>& action, ErrorCode code) {
  try {
    action();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    return error.what();
  }
  return "accepted";
}

void expectRefused(const std::vector<std::byte>& bytes, ErrorCode code, const std::string& why) {
  EXPECT_NE(refusal([&] { decodeTextureSet(bytes); }, code).find(why), std::string::npos) << why;
}

void expectNotEncoded(const TextureSet& set, ErrorCode code, const std::string& why) {
  EXPECT_NE(refusal([&] { encodeTextureSet(set); }, code).find(why), std::string::npos) << why;
}

/// Overwrites the bytes at a place of an encoded set.
template <typename T>
std::vector<std::byte> patched(size_t at, T value, const TextureSet& set = sampleSet()) {
  std::vector<std::byte> bytes = encodeTextureSet(set);
  std::memcpy(&bytes[at], &value, sizeof value);
  return bytes;
}

// Places in the bytes of sampleSet().
constexpr size_t kOriginAt = 1, kExponentAt = 17, kTexturesAt = 21, kNameAt = 25, kWidthAt = 25 + 2 + 10;
constexpr size_t kFirstTileAt = kWidthAt + 8;

TEST(TextureSet, hasAKnownSizeIfEmpty) { EXPECT_EQ(encodeTextureSet({}).size(), kEmptyTextureSetBytes); }

TEST(Texture, hasLevelsDownToTheFirstThatFitsATile) {
  EXPECT_EQ(levelCount(sized(0, 0)), 0u);
  EXPECT_EQ(levelCount(sized(1, 1)), 1u);
  EXPECT_EQ(levelCount(sized(508, 508)), 1u);
  EXPECT_EQ(levelCount(sized(509, 1)), 2u);
  EXPECT_EQ(levelCount(sized(1, 1017)), 3u);
  EXPECT_EQ(levelCount(sized(65536, 65536)), 9u);
}

TEST(Texture, levelsHalveAndRoundUp) {
  EXPECT_EQ(levelSize(sized(1017, 3), 0), glm::uvec2(1017, 3));
  EXPECT_EQ(levelSize(sized(1017, 3), 1), glm::uvec2(509, 2));
  EXPECT_EQ(levelSize(sized(1017, 3), 2), glm::uvec2(255, 1));
  EXPECT_EQ(levelSize(sized(1017, 3), 31), glm::uvec2(1, 1));
}

TEST(Texture, tilesStandCoarsestFirstAndByRows) {
  const Texture texture = sized(1200, 600);
  ASSERT_EQ(levelCount(texture), 3u);  // sizes 1200 x 600, 600 x 300 and 300 x 150
  EXPECT_EQ(tilesAcross(texture, 0), 3u);
  EXPECT_EQ(tilesDown(texture, 0), 2u);
  EXPECT_EQ(tilesAcross(texture, 1), 2u);
  EXPECT_EQ(tileCount(texture), 1u + 2u + 6u);
  EXPECT_EQ(tileIndex(texture, 2, 0, 0), 0u);
  EXPECT_EQ(tileIndex(texture, 1, 1, 0), 2u);
  EXPECT_EQ(tileIndex(texture, 0, 0, 0), 3u);
  EXPECT_EQ(tileIndex(texture, 0, 2, 1), 8u);
}

TEST(Texture, hasSmallerTilesAtItsEdges) {
  const Texture texture = sized(1200, 600);
  EXPECT_EQ(tileInnerSize(texture, 0, 0, 0), glm::uvec2(508, 508));
  EXPECT_EQ(tileInnerSize(texture, 0, 2, 1), glm::uvec2(184, 92));
  EXPECT_EQ(tileInnerSize(texture, 2, 0, 0), glm::uvec2(300, 150));
}

TEST(TileKind, isRecognizedByTheFirstBytes) {
  const auto kind = [](std::string_view text) { return tileKind(std::as_bytes(std::span(text))); };
  EXPECT_EQ(kind("\xff\xd8\xff\xe0"), TileKind::kJpeg);
  EXPECT_EQ(kind("RIFF----WEBPVP8 "), TileKind::kWebp);
  EXPECT_EQ(kind("RIFF----WAVE"), std::nullopt);
  EXPECT_EQ(kind("\xff\xd8"), std::nullopt);
  EXPECT_EQ(kind(""), std::nullopt);
}

TEST(TextureSet, decodesToTheEncodedSet) {
  EXPECT_EQ(decodeTextureSet(encodeTextureSet(sampleSet())), sampleSet());
  EXPECT_EQ(decodeTextureSet(encodeTextureSet({})), TextureSet());
}

TEST(TextureSet, statesTheStepOfItsCodes) {
  EXPECT_EQ(uvStep({}), 0x1p-16);
  EXPECT_EQ(uvStep(sampleSet()), 0x1p-19);
}

TEST(TextureSet, isRefusedIfTruncatedAnywhere) {
  const std::vector<std::byte> bytes = encodeTextureSet(sampleSet());
  for (size_t length = 0; length < bytes.size(); ++length)
    expectRefused({bytes.begin(), bytes.begin() + static_cast<ptrdiff_t>(length)}, ErrorCode::kFormat,
                  "cut off");
}

TEST(TextureSet, isRefusedWithBytesAfterItsEnd) {
  std::vector<std::byte> bytes = encodeTextureSet(sampleSet());
  bytes.push_back({});
  expectRefused(bytes, ErrorCode::kFormat, "bytes follow");
}

TEST(TextureSet, refusesOrRevealsEveryChangedByte) {
  std::vector<std::byte> bytes = encodeTextureSet(sampleSet());
  for (std::byte& byte : bytes) {
    const std::byte old = byte;
    byte ^= std::byte{0x41};
    try {
      EXPECT_FALSE(decodeTextureSet(bytes) == sampleSet());
    } catch (const Error&) {
    }
    byte = old;
  }
}

TEST(TextureSet, isRefusedIfItIsOfAnotherVersion) {
  expectRefused(patched(0, uint8_t{2}), ErrorCode::kFormat, "version");
}

TEST(TextureSet, isRefusedWithAScaleOutOfRange) {
  for (const double origin : {std::nan(""), std::numeric_limits<double>::infinity(), -0x1p61})
    expectRefused(patched(kOriginAt, origin), ErrorCode::kFormat, "origin");
  for (const int32_t exponent :
       {kMaxUvExponent + 1, -kMaxUvExponent - 1, std::numeric_limits<int32_t>::min()})
    expectRefused(patched(kExponentAt, exponent), ErrorCode::kFormat, "scale");
}

TEST(TextureSet, isRefusedAboveAnyLimitBeforeItIsRead) {
  expectRefused(patched(kTexturesAt, kMaxTextures + 1), ErrorCode::kLimit, "textures");
  expectRefused(patched(kWidthAt, kMaxTextureEdgePx + 1), ErrorCode::kLimit, "texels");
  expectRefused(patched(kFirstTileAt + 4, kMaxTileBytes + 1), ErrorCode::kLimit, "bytes in a tile");
  expectRefused(std::vector<std::byte>(kMaxTextureSetBytes + 1), ErrorCode::kLimit, "bytes");
  std::vector<std::byte> long_name = patched(kNameAt, static_cast<uint16_t>(kMaxTextureNameBytes + 1));
  long_name.resize(long_name.size() + kMaxTextureNameBytes);
  expectRefused(long_name, ErrorCode::kLimit, "name");
}

TEST(TextureSet, isRefusedWithMoreTilesThanTheLimit) {
  // Announces 47 images of 65536 x 65536 texels: 22,000 tiles each.
  std::vector<std::byte> bytes = encodeTextureSet({});
  const Texture largest = withTiles("", kMaxTextureEdgePx, kMaxTextureEdgePx);
  TextureSet one;
  one.textures = {largest};
  const std::vector<std::byte> encoded = encodeTextureSet(one);
  const uint32_t textures = kMaxTextureTiles / static_cast<uint32_t>(largest.tiles.size()) + 1;
  std::memcpy(&bytes[kTexturesAt], &textures, sizeof textures);
  for (uint32_t i = 0; i < textures; ++i) bytes.insert(bytes.end(), encoded.begin() + kNameAt, encoded.end());
  ASSERT_LE(bytes.size(), kMaxTextureSetBytes);
  expectRefused(bytes, ErrorCode::kLimit, "tiles");
}

TEST(TextureSet, isRefusedWithAnImageOfOneDimension) {
  expectRefused(patched(kWidthAt, uint32_t{0}), ErrorCode::kFormat, "width or a height");
}

TEST(TextureSet, isRefusedWithoutABlobForATile) {
  expectRefused(patched(kFirstTileAt, uint32_t{0}), ErrorCode::kFormat, "tile is missing");
  expectRefused(patched(kFirstTileAt + 4, uint32_t{0}), ErrorCode::kFormat, "tile is missing");
}

TEST(TextureSet, isRefusedWithAnUnprintableName) {
  for (const char character : {'\x1b', '\0', '\x7f', '\xff'})
    expectRefused(patched(kNameAt + 2, character), ErrorCode::kFormat, "printable");
}

TEST(TextureSet, isNotEncodedIfItCouldNotBeDecoded) {
  TextureSet set = sampleSet();
  set.textures[0].tiles.pop_back();
  expectNotEncoded(set, ErrorCode::kFormat, "tiles do not fit");
  set = sampleSet();
  set.textures[0].tiles[2].number = 0;
  expectNotEncoded(set, ErrorCode::kFormat, "tile is missing");
  set = sampleSet();
  set.textures[0].name = std::string(kMaxTextureNameBytes + 1, 'x');
  expectNotEncoded(set, ErrorCode::kLimit, "name");
  set = sampleSet();
  set.uv_scale_exponent = 100;
  expectNotEncoded(set, ErrorCode::kFormat, "scale");
  set = {};
  set.textures.resize(kMaxTextures + 1);
  expectNotEncoded(set, ErrorCode::kLimit, "textures");
}

}  // namespace
}  // namespace lode
