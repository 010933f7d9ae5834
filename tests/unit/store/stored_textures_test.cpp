// Texture sets in stores: reading them back, and errors of hostile ones.

#include <cstring>

#include <png.h>

#include "server/store/export.h"
#include "server/store/format.h"
#include "server/store/reader.h"
#include "server/store/verify.h"
#include "tests/support/texture_images.h"
#include "tests/unit/store/store_files.h"

namespace lode::store {
namespace {

class StoredTextures : public testing::Test {
 protected:
  ModelSummary write(const std::function<TextureSet(Writer&)>& add) {
    test::SyntheticModel model = test::smallModel();
    return test::writeStore(path_, model, add);
  }

  test::WorkFolder folder_;
  std::filesystem::path path_ = folder_ / "a.lode";
};

TextureSet twoTextures(Writer& writer) {
  TextureSet set;
  set.uv_scale_exponent = 2;
  set.textures = {test::addFakeTexture(writer, "bark 1.png", 600, 300), Texture{"missing.png", 0, 0, {}},
                  test::addFakeTexture(writer, "leaf", 8, 8)};
  return set;
}

TEST_F(StoredTextures, areReadBackFromTheStore) {
  TextureSet written;
  const ModelSummary summary = write([&](Writer& writer) { return written = twoTextures(writer); });
  const Reader reader(path_);
  EXPECT_EQ(reader.textures(), written);
  EXPECT_EQ(reader.summary(), summary);
  EXPECT_EQ(decodeTextureSet(reader.readBlob(summary.textures.number)), written);
}

TEST_F(StoredTextures, areAbsentFromAStoreWithoutThem) {
  EXPECT_FALSE(write({}).textures);
  EXPECT_EQ(Reader(path_).textures(), TextureSet());
}

TEST_F(StoredTextures, mayShareTiles) {
  write([](Writer& writer) {
    TextureSet set;
    set.textures = {test::addFakeTexture(writer, "same", 600, 300),
                    test::addFakeTexture(writer, "same", 600, 300)};
    return set;
  });
  const Reader reader(path_);
  EXPECT_EQ(reader.textures().textures[0].tiles, reader.textures().textures[1].tiles);
}

TEST_F(StoredTextures, areRefusedIfTheirTilesDifferFromTheTable) {
  const ModelSummary summary = write(twoTextures);
  // Rewrite the set in place, with the checksums of everything above it.
  std::vector<char> file = test::readFile(path_);
  uint64_t at = 0;
  std::vector<std::byte> blob;
  {
    const Reader reader(path_);
    at = reader.blob(summary.textures.number).offset;
    blob = reader.readBlob(summary.textures.number);
  }
  blob[blob.size() - 1] ^= std::byte{1};  // the last tile's digest
  std::memcpy(&file[at], blob.data(), blob.size());
  const std::span<std::byte> bytes = std::as_writable_bytes(std::span(file));
  FileHeader header = decodeHeader(bytes.first<kHeaderBytes>(), bytes.size());
  const auto table_bytes = bytes.subspan(header.table_offset, header.blobs * kTableEntryBytes);
  std::vector<TableEntry> table = decodeTable(table_bytes, header);
  table[summary.textures.number - 1].checksum = checksum(blob);
  table[summary.textures.number - 1].digest = digestOf(blob);
  const std::vector<std::byte> new_table = encodeTable(table);
  std::copy(new_table.begin(), new_table.end(), table_bytes.begin());
  header.table_checksum = checksum(new_table);
  header.summary.build_id = computeBuildId(header, new_table);
  const auto new_header = encodeHeader(header);
  std::copy(new_header.begin(), new_header.end(), bytes.begin());
  const auto footer = encodeFooter(new_header);
  std::copy(footer.begin(), footer.end(), bytes.end() - kFooterBytes);
  test::writeFile(path_, file);
  EXPECT_NE(test::messageOf([&] { Reader reader(path_); }).find("texture leaf: size or digest"),
            std::string::npos);
}

TEST_F(StoredTextures, areRefusedInTheOldFormatWithAdviceToRebuild) {
  write({});
  std::vector<char> file = test::readFile(path_);
  file[8] = 1;
  test::writeFile(path_, file);
  EXPECT_NE(test::messageOf([&] { Reader reader(path_); }).find("build the store anew"), std::string::npos);
}

/// Adds a texture with real tiles.
Texture addTexture(Writer& writer, const std::string& name, const test::TextureImages& images) {
  Texture texture = images.texture();
  texture.name = name;
  texture.tiles.clear();
  images.forEachTile([&](uint32_t level, uint32_t x, uint32_t y) {
    texture.tiles.push_back(writer.addBlob(test::webpOf(images.tile(level, x, y))));
  });
  return texture;
}

test::TextureImages gradient(uint32_t width, uint32_t height) {
  return test::TextureImages(width, height, [](uint32_t x, uint32_t y) {
    return glm::u8vec4(x & 255, y & 255, x >> 8 << 4 | y >> 8, 255 - (x + y) % 7);
  });
}

TEST_F(StoredTextures, areDecodedByVerify) {
  write([](Writer& writer) {
    TextureSet set;
    set.textures = {addTexture(writer, "a", gradient(600, 300))};
    return set;
  });
  EXPECT_EQ(verifyStore(path_).tiles, 3u);
}

TEST_F(StoredTextures, areRejectedByVerifyIfTilesAreNoImages) {
  write(twoTextures);
  EXPECT_NE(test::messageOf([&] { verifyStore(path_); }).find("texture bark 1.png, level 0, tile 0 0"),
            std::string::npos);
}

TEST_F(StoredTextures, areRejectedByVerifyIfTilesHaveAnotherSize) {
  write([](Writer& writer) {
    TextureSet set;
    set.textures = {addTexture(writer, "a", gradient(30, 20))};
    set.textures[0].width = 31;
    return set;
  });
  EXPECT_NE(test::messageOf([&] { verifyStore(path_); }).find("texture a, level 0"), std::string::npos);
}

std::vector<glm::u8vec4> readPng(const std::filesystem::path& path, glm::uvec2& size) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  EXPECT_NE(png_image_begin_read_from_file(&png, path.c_str()), 0) << path;
  size = {png.width, png.height};
  png.format = PNG_FORMAT_RGBA;
  std::vector<glm::u8vec4> texels(size_t{png.width} * png.height);
  EXPECT_NE(png_image_finish_read(&png, nullptr, texels.data(), 0, nullptr), 0) << png.message;
  return texels;
}

TEST_F(StoredTextures, areExportedAsImagesBesideThePly) {
  write([](Writer& writer) {
    TextureSet set;
    set.uv_scale_exponent = 4;
    set.textures = {addTexture(writer, "../../two words.png", gradient(1100, 520)),
                    {"missing.png", 0, 0, {}},
                    addTexture(writer, "C:\\two words.jpg", gradient(3, 2))};
    return set;
  });
  std::filesystem::create_directory(folder_ / "out");
  const ImageFiles files = exportTextures(Reader(path_), folder_ / "out/cut.ply");
  const TextureSet& set = files.set;
  EXPECT_EQ(set.uv_scale_exponent, 4);
  ASSERT_EQ(set.textures.size(), 3u);
  EXPECT_EQ(set.textures[0].name, "cut_two words.png");
  EXPECT_EQ(set.textures[1].name, "missing.png");
  EXPECT_EQ(set.textures[2].name, "cut_two words-2.png");
  EXPECT_EQ(files.has_alpha, (std::vector<bool>{true, false, true}));
  glm::uvec2 size;
  const std::vector<glm::u8vec4> texels = readPng(folder_ / "out/cut_two words.png", size);
  ASSERT_EQ(size, glm::uvec2(1100, 520));
  size_t i = 0;
  for (uint32_t y = 0; y < size.y; ++y)
    for (uint32_t x = 0; x < size.x; ++x, ++i)
      ASSERT_EQ(texels[i], glm::u8vec4(x & 255, y & 255, x >> 8 << 4 | y >> 8, 255 - (x + y) % 7));
  EXPECT_EQ(readPng(folder_ / "out/cut_two words-2.png", size).size(), 6u);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "two words.png"));
}

/// Returns true if the file has an alpha channel.
bool hasAlphaChannel(const std::filesystem::path& path) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  EXPECT_NE(png_image_begin_read_from_file(&png, path.c_str()), 0) << path;
  const bool has_alpha = (png.format & PNG_FORMAT_FLAG_ALPHA) != 0;
  png_image_free(&png);
  return has_alpha;
}

TEST_F(StoredTextures, areExportedWithAlphaOnlyIfATexelIsClear) {
  const auto clearAt = [](uint32_t clear_x) {
    return test::TextureImages(600, 300, [clear_x](uint32_t x, uint32_t y) {
      return glm::u8vec4(x & 255, y & 255, 0, x == clear_x && y == 299 ? 254 : 255);
    });
  };
  write([&](Writer& writer) {
    TextureSet set;
    set.textures = {addTexture(writer, "opaque", clearAt(600)), addTexture(writer, "clear", clearAt(599))};
    return set;
  });
  const ImageFiles files = exportTextures(Reader(path_), folder_ / "cut.glb");
  EXPECT_EQ(files.has_alpha, (std::vector<bool>{false, true}));
  EXPECT_FALSE(hasAlphaChannel(folder_ / "cut_opaque.png"));
  EXPECT_TRUE(hasAlphaChannel(folder_ / "cut_clear.png"));
}

TEST_F(StoredTextures, truncateLongNamesBetweenCharacters) {
  write([](Writer& writer) {
    TextureSet set;
    set.textures = {addTexture(writer, std::string(99, 'x') + "\xc3\xbcy.png", gradient(3, 2))};
    return set;
  });
  const ImageFiles exported = exportTextures(Reader(path_), folder_ / "a.ply");
  EXPECT_EQ(exported.set.textures[0].name, "a_" + std::string(99, 'x') + ".png");
}

TEST_F(StoredTextures, leaveNoHalfImageWhenExportFails) {
  write([](Writer& writer) {
    TextureSet set;
    set.textures = {test::addFakeTexture(writer, "a", 8, 8)};
    return set;
  });
  std::filesystem::create_directory(folder_ / "out");
  EXPECT_THROW(exportTextures(Reader(path_), folder_ / "out/cut.ply"), Error);
  EXPECT_TRUE(std::filesystem::is_empty(folder_ / "out"));
  EXPECT_THROW(exportTextures(Reader(path_), folder_ / "nowhere/cut.ply"), Error);
}

}  // namespace
}  // namespace lode::store
