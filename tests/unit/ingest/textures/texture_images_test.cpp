#include "server/ingest/textures/texture_images.h"

#include <gtest/gtest.h>

#include "common/codec/texture_set.h"
#include "common/error.h"
#include "server/ingest/textures/tile_encoder.h"
#include "tests/support/work_folder.h"
#include "tests/unit/ingest/textures/image_files.h"

namespace lode::ingest {
namespace {

using test::makePhoto;
using test::pngHeader;
using test::pngOf;
using test::writeBytes;

constexpr uint64_t kAmple = 1ull << 50;

class TextureImages : public testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directory(models_); }

  std::string problemOf(const std::string& name) const {
    return findTexture(models_ / "a.ply", name).problem;
  }

  std::vector<TextureImage> surveyed(const std::vector<std::string>& names,
                                     uint64_t memory_bytes = kAmple) const {
    return surveyTextures(models_ / "a.ply", names, memory_bytes);
  }

  test::WorkFolder folder_;
  std::filesystem::path models_ = folder_ / "models";
};

TEST_F(TextureImages, areFoundBesideTheFileAndBelow) {
  std::filesystem::create_directories(models_ / "maps");
  writeBytes(models_ / "two words.png", pngOf(makePhoto(2, 2)));
  writeBytes(models_ / "maps" / "b.png", pngOf(makePhoto(2, 2)));
  std::filesystem::create_symlink("maps/b.png", models_ / "inner.png");
  for (const char* name : {"two words.png", "maps/b.png", "inner.png"})
    EXPECT_EQ(problemOf(name), "") << name;
}

TEST_F(TextureImages, outsideTheFolderAreNotRead) {
  writeBytes(folder_ / "outside.png", pngOf(makePhoto(2, 2)));
  std::filesystem::create_symlink(folder_ / "outside.png", models_ / "link.png");
  std::filesystem::create_directories(models_ / "maps");
  for (const std::string& name : {(folder_ / "outside.png").string(), std::string("../outside.png"),
                                  std::string("maps/../../outside.png"), std::string("link.png")})
    EXPECT_NE(problemOf(name).find("PLY file's folder"), std::string::npos) << name;
}

TEST_F(TextureImages, areFoundBesideALinkToTheFileFirstThenBesideTheFile) {
  std::filesystem::create_directory(folder_ / "links");
  writeBytes(models_ / "a.ply", pngOf(makePhoto(2, 2)));
  writeBytes(models_ / "a.png", pngOf(makePhoto(2, 2)));
  std::filesystem::create_symlink("../models/a.ply", folder_ / "links" / "b.ply");
  const auto found = [&](const std::string& name) { return findTexture(folder_ / "links" / "b.ply", name); };
  EXPECT_EQ(found("a.png").problem, "");
  EXPECT_EQ(found("a.png").path, std::filesystem::canonical(models_ / "a.png"));
  writeBytes(folder_ / "links" / "a.png", pngOf(makePhoto(2, 2)));
  EXPECT_EQ(found("a.png").path, std::filesystem::canonical(folder_ / "links" / "a.png"));
  const std::string problem = found("gone.png").problem;
  for (const auto& searched : {models_, folder_ / "links"})
    EXPECT_NE(problem.find(std::filesystem::canonical(searched).string() + "'"), std::string::npos)
        << problem;
  EXPECT_NE(found("../models/a.png").problem, "") << "a path out of the folder is none all the same";
}

TEST_F(TextureImages, thatAreNotThereNameTheFolderThatWasSearched) {
  EXPECT_NE(problemOf("gone.png").find("'" + std::filesystem::canonical(models_).string() + "'"),
            std::string::npos)
      << problemOf("gone.png");
}

TEST_F(TextureImages, namedWithTheirWholePathAreFoundInTheFilesFolder) {
  writeBytes(models_ / "a.png", pngOf(makePhoto(2, 2)));
  EXPECT_EQ(problemOf((models_ / "a.png").string()), "");
}

TEST_F(TextureImages, ofAnotherSystemsPathAreToBeNamedWithoutOne) {
  for (const char* name : {"C:\\scans\\x.png", "maps\\x.png"})
    EXPECT_NE(problemOf(name).find("name it without a path"), std::string::npos) << problemOf(name);
}

TEST_F(TextureImages, thatAreNoFilesAreNotRead) {
  std::filesystem::create_directories(models_ / "folder.png");
  EXPECT_NE(problemOf("folder.png"), "");
  EXPECT_NE(problemOf("missing.png"), "");
  EXPECT_NE(problemOf(std::string("nul\0.png", 8)), "");
  EXPECT_NE(problemOf(std::string(5000, 'x')), "");
}

TEST_F(TextureImages, haveTheSizesOfTheirHeadersOrAProblem) {
  writeBytes(models_ / "a.png", pngHeader(30000, 20000));
  writeBytes(models_ / "b.jpg", encodeTile(makePhoto(70, 50), TileCodec::kJpeg));
  writeBytes(models_ / "c.webp", encodeTile(makePhoto(70, 50), TileCodec::kLossless));
  writeBytes(models_ / "d.png", pngHeader(65537, 1));
  const std::vector<TextureImage> images = surveyed({"a.png", "b.jpg", "c.webp", "d.png", "gone.png"});
  ASSERT_EQ(images.size(), 5u);
  EXPECT_EQ(images[0].header.width, 30000u);
  EXPECT_EQ(images[0].header.height, 20000u);
  EXPECT_EQ(images[1].header.width, 70u);
  EXPECT_EQ(images[2].header.height, 50u);
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(images[i].problem, "");
    EXPECT_EQ(images[i].file_bytes, std::filesystem::file_size(images[i].path));
    EXPECT_GE(images[i].memoryBytes(),
              images[i].file_bytes + images[i].header.width * images[i].header.height * 5);
  }
  EXPECT_NE(images[3].problem.find("the limit is 65536"), std::string::npos);
  EXPECT_FALSE(images[3].needs_memory);
  EXPECT_NE(images[4].problem, "");
}

TEST_F(TextureImages, thatAnnounceMoreThanTheyMayTakeNameTheRemedy) {
  writeBytes(models_ / "huge.png", pngHeader(65536, 65536));
  const std::vector<TextureImage> images = surveyed({"huge.png"}, 1ull << 30);
  EXPECT_NE(images[0].problem.find("has 65536 x 65536 pixels"), std::string::npos) << images[0].problem;
  EXPECT_NE(images[0].problem.find("raise it to 25.9GB or"), std::string::npos) << images[0].problem;
  EXPECT_NE(images[0].problem.find("scale the image down"), std::string::npos) << images[0].problem;
  EXPECT_TRUE(images[0].needs_memory);
  EXPECT_EQ(images[0].header.width, 0u);
}

TEST_F(TextureImages, areTakenUpToTheirShareOfTheMemoryAndNotAByteMore) {
  writeBytes(models_ / "a.png", pngOf(makePhoto(300, 200)));
  const uint64_t needed = surveyed({"a.png"})[0].memoryBytes();
  EXPECT_EQ(surveyed({"a.png"}, needed)[0].problem, "");
  EXPECT_NE(surveyed({"a.png"}, needed - 1)[0].problem, "");
  const std::vector<std::byte> file = readImageFile(models_ / "a.png", needed);
  std::string damage;
  EXPECT_EQ(decodeImage(file, needed - file.size(), damage), makePhoto(300, 200));
  EXPECT_THROW(decodeImage(file, needed - file.size() - 1, damage), Error);
}

TEST_F(TextureImages, whoseFilesAloneTakeTooMuchAreNotRead) {
  writeBytes(models_ / "a.png", pngOf(makePhoto(300, 200)));
  std::filesystem::resize_file(models_ / "a.png", 1ull << 36);
  const std::vector<TextureImage> images = surveyed({"a.png"}, 1 << 20);
  EXPECT_NE(images[0].problem.find("needs 68.8GB"), std::string::npos) << images[0].problem;
  EXPECT_TRUE(images[0].needs_memory);
}

TEST_F(TextureImages, ofMoreTilesThanAStoreTakesAreRefusedWithTheirNumber) {
  writeBytes(models_ / "a.png", pngHeader(kMaxTextureEdgePx, kMaxTextureEdgePx));
  const uint64_t tiles = tileCount({{}, kMaxTextureEdgePx, kMaxTextureEdgePx, {}});
  std::vector<std::string> names(kMaxTextureTiles / tiles, "a.png");
  EXPECT_EQ(surveyed(names).size(), names.size());
  names.push_back("a.png");
  try {
    surveyed(names);
    ADD_FAILURE() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInput);
    const std::string text = error.what();
    EXPECT_NE(text.find(std::to_string(tiles * names.size()) + " tiles"), std::string::npos) << text;
    EXPECT_NE(text.find("scale them down"), std::string::npos) << text;
  }
}

TEST_F(TextureImages, areCountedBeforeAnyIsLookedFor) {
  EXPECT_THROW(surveyed(std::vector<std::string>(kMaxTextures + 1, "a.png")), Error);
}

}  // namespace
}  // namespace lode::ingest
