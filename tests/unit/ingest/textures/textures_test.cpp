#include "server/ingest/textures/textures.h"

#include <gtest/gtest.h>

#include "common/error.h"
#include "server/ingest/pipeline/build.h"
#include "server/store/reader.h"
#include "tests/support/work_folder.h"
#include "tests/unit/ingest/textures/image_files.h"

namespace lode::ingest {
namespace {

using test::makePhoto;
using test::pngOf;
using test::writeBytes;

/// Makes two triangles with texture coordinates from `low` to `high`, and materials 0 and 1.
std::string quad(const std::vector<std::string>& textures, const std::string& low = "0",
                 const std::string& high = "1") {
  std::string text = "ply\nformat ascii 1.0\n";
  for (const std::string& name : textures) text += "comment TextureFile " + name + "\n";
  text +=
      "element vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 2\n"
      "property list uchar int vertex_indices\nproperty list uchar float texcoord\n"
      "property int texnumber\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
  const std::string l = " " + low, h = " " + high, last = textures.size() > 1 ? " 1\n" : " 0\n";
  return text + "3 0 1 2 6" + l + l + h + l + h + h + " 0\n3 0 2 3 6" + l + l + h + h + l + h + last;
}

class Textures : public testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directory(models_); }

  void write(const std::string& name, const std::string& text) const {
    std::ofstream(models_ / name, std::ios::binary) << text;
  }

  BuildReport built(const std::vector<std::string>& textures, bool strict = false, unsigned threads = 2) {
    write("a.ply", quad(textures, low_, high_));
    BuildOptions options;
    options.input = models_ / "a.ply";
    options.output = store_;
    options.strict = strict;
    options.threads = threads;
    options.memory_bytes = memory_bytes_;
    return build(options);
  }

  test::WorkFolder folder_;
  std::filesystem::path models_ = folder_ / "models", store_ = folder_ / "a.lode";
  std::string low_ = "0", high_ = "1";
  uint64_t memory_bytes_ = 256 << 20;
};

TEST_F(Textures, goIntoTheStoreWithNamesSizesAndAllTiles) {
  writeBytes(models_ / "two words.png", pngOf(makePhoto(600, 300)));
  writeBytes(models_ / "clear.png", pngOf(makePhoto(20, 30, true)));
  EXPECT_TRUE(built({"two words.png", "clear.png"}).warnings.empty());
  const store::Reader reader(store_);
  const TextureSet& set = reader.textures();
  ASSERT_EQ(set.textures.size(), 2u);
  EXPECT_EQ(set.textures[0].name, "two words.png");
  EXPECT_EQ(set.textures[0].width, 600u);
  EXPECT_EQ(set.textures[0].tiles.size(), 3u);
  EXPECT_EQ(set.textures[1].height, 30u);
  EXPECT_EQ(tileKind(reader.readBlob(set.textures[0].tiles[0].number)), TileKind::kJpeg);
  EXPECT_EQ(tileKind(reader.readBlob(set.textures[1].tiles[0].number)), TileKind::kWebp);
}

TEST_F(Textures, tilesHoldTheirPartOfTheImageAndItsSurroundings) {
  Image drawing = makePhoto(600, 300);
  for (glm::u8vec4& texel : drawing.texels) texel = (texel & glm::u8vec4(0xc0)) | glm::u8vec4(0, 0, 0, 0xff);
  writeBytes(models_ / "a.png", pngOf(drawing));
  built({"a.png"});
  const store::Reader reader(store_);
  const Texture& texture = reader.textures().textures[0];
  for (uint32_t x = 0; x < 2; ++x) {
    const std::vector<std::byte> file = reader.readBlob(texture.tiles[tileIndex(texture, 0, x, 0)].number);
    std::string damage;
    const Image tile = decodeImage(file, 1 << 24, damage);
    EXPECT_EQ(tile.size, tileInnerSize(texture, 0, x, 0) + 2 * kTileGutterPx);
    EXPECT_EQ(tile, cutOut(drawing, {static_cast<int>(508 * x) - 2, -2}, tile.size));
  }
}

TEST_F(Textures, lieInTheStoreCoarseLevelsFirst) {
  writeBytes(models_ / "large.png", pngOf(makePhoto(1200, 1200)));
  writeBytes(models_ / "small.png", pngOf(makePhoto(600, 600)));
  built({"large.png", "small.png"});
  const store::Reader reader(store_);
  const TextureSet& set = reader.textures();
  EXPECT_EQ(set.textures[0].tiles[0].number, 1u);
  EXPECT_EQ(set.textures[1].tiles[0].number, 2u);
  EXPECT_EQ(set.textures[0].tiles[1].number, 3u);
  EXPECT_EQ(set.textures[1].tiles[1].number, 7u);
  EXPECT_EQ(set.textures[0].tiles[5].number, 11u);
}

TEST_F(Textures, giveTheSameStoreForAnyNumberOfThreads) {
  writeBytes(models_ / "a.png", pngOf(makePhoto(1300, 700)));
  writeBytes(models_ / "b.png", pngOf(makePhoto(700, 600, true)));
  Digest expected;
  for (const unsigned threads : {1u, 2u, 7u}) {
    const Digest id = built({"a.png", "b.png"}, false, threads).summary.build_id;
    if (threads == 1) expected = id;
    EXPECT_EQ(id, expected);
  }
}

TEST_F(Textures, causeWarningsAndHaveNoTilesIfUnreadable) {
  write("text.png", "not a picture");
  writeBytes(models_ / "huge.png", test::pngHeader(70000, 1));
  writeBytes(models_ / "good.png", pngOf(makePhoto(4, 4)));
  const BuildReport report = built({"missing one.png", "../up.png", "text.png", "huge.png", "good.png"});
  ASSERT_EQ(report.warnings.size(), 4u);
  EXPECT_NE(report.warnings[0].find("'missing one.png'"), std::string::npos) << report.warnings[0];
  const store::Reader reader(store_);
  ASSERT_EQ(reader.textures().textures.size(), 5u);
  for (size_t i = 0; i < 4; ++i) EXPECT_EQ(reader.textures().textures[i].width, 0u);
  EXPECT_EQ(reader.textures().textures[4].width, 4u);
}

TEST_F(Textures, failAStrictBuildIfMissing) {
  EXPECT_THROW(built({"missing.png"}, true), Error);
  EXPECT_FALSE(std::filesystem::exists(store_));
}

TEST_F(Textures, failTheBuildWithAdviceAboveTheMemory) {
  writeBytes(models_ / "large.png", pngOf(makePhoto(2000, 2000)));
  memory_bytes_ = 20 << 20;
  try {
    built({"large.png"});
    ADD_FAILURE() << "built";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kLimit);
    EXPECT_NE(std::string(error.what()).find("'large.png' has 2000 x 2000 pixels"), std::string::npos)
        << error.what();
    EXPECT_NE(std::string(error.what()).find("--memory; raise it to"), std::string::npos) << error.what();
  }
  EXPECT_FALSE(std::filesystem::exists(store_));
}

TEST_F(Textures, failTheBuildBeforeItReadsTheModelAboveTheTileLimit) {
  writeBytes(models_ / "a.png", test::pngHeader(65536, 65536));
  write("a.ply", quad(std::vector<std::string>(60, "a.png")) + "what is not read is not refused");
  std::filesystem::resize_file(models_ / "a.ply", std::filesystem::file_size(models_ / "a.ply") - 60);
  BuildOptions options;
  options.input = models_ / "a.ply";
  options.output = store_;
  options.memory_bytes = 1ull << 40;
  try {
    build(options);
    ADD_FAILURE() << "built";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("tiles; the limit is 1048576"), std::string::npos)
        << error.what();
  }
}

TEST_F(Textures, haveNamesThatATextureSetTakes) {
  built({"a\x1b[2J\xff.png", std::string(3000, 'x')});
  const store::Reader reader(store_);
  EXPECT_EQ(reader.textures().textures.size(), 2u);
}

TEST_F(Textures, giveCoordinatesOutsideTheImageTheirScale) {
  low_ = "-3";
  high_ = "5";
  writeBytes(models_ / "a.png", pngOf(makePhoto(4, 4)));
  EXPECT_TRUE(built({"a.png"}).warnings.empty());
  const store::Reader reader(store_);
  EXPECT_EQ(reader.textures().uv_origin, glm::dvec2(-3));
  EXPECT_EQ(reader.textures().uv_scale_exponent, 3);
}

TEST_F(Textures, warnWhereCoordinatesAreCoarserThanTheImage) {
  low_ = "0";
  high_ = "100";
  writeBytes(models_ / "a.png", pngOf(makePhoto(1024, 4)));
  const BuildReport report = built({"a.png"});
  ASSERT_EQ(report.warnings.size(), 1u);
  EXPECT_NE(report.warnings[0].find("rounded to 2.0"), std::string::npos) << report.warnings[0];
}

}  // namespace
}  // namespace lode::ingest
