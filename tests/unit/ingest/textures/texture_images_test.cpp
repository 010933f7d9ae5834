#include "server/ingest/textures/texture_images.h"

#include <gtest/gtest.h>

#include "common/codec/texture_set.h"
#include "common/error.h"
#include "server/store/tile_encoder.h"
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

  std::vector<TextureImage> surveyed(const std::vector<std::string>& names,
                                     uint64_t memory_bytes = kAmple) const {
    return surveyTextures(imagesOf(models_ / "a.ply", names), {}, memory_bytes);
  }

  test::WorkFolder folder_;
  std::filesystem::path models_ = folder_ / "models";
};

TEST_F(TextureImages, haveTheSizesOfTheirHeadersOrAProblem) {
  writeBytes(models_ / "a.png", pngHeader(30000, 20000));
  writeBytes(models_ / "b.jpg", store::encodeTile(makePhoto(70, 50), store::TileCodec::kJpeg));
  writeBytes(models_ / "c.webp", store::encodeTile(makePhoto(70, 50), store::TileCodec::kLossless));
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

TEST_F(TextureImages, nameTheRemedyIfTheyExceedTheMemory) {
  writeBytes(models_ / "huge.png", pngHeader(65536, 65536));
  const std::vector<TextureImage> images = surveyed({"huge.png"}, 1ull << 30);
  EXPECT_NE(images[0].problem.find("has 65536 x 65536 pixels"), std::string::npos) << images[0].problem;
  EXPECT_NE(images[0].problem.find("raise it to 25.9GB or"), std::string::npos) << images[0].problem;
  EXPECT_NE(images[0].problem.find("scale the image down"), std::string::npos) << images[0].problem;
  EXPECT_TRUE(images[0].needs_memory);
  EXPECT_EQ(images[0].header.width, 0u);
}

TEST_F(TextureImages, areAcceptedUpToExactlyTheirMemoryShare) {
  writeBytes(models_ / "a.png", pngOf(makePhoto(300, 200)));
  const uint64_t needed = surveyed({"a.png"})[0].memoryBytes();
  EXPECT_EQ(surveyed({"a.png"}, needed)[0].problem, "");
  EXPECT_NE(surveyed({"a.png"}, needed - 1)[0].problem, "");
  const std::vector<std::byte> file = readImageFile(models_ / "a.png", needed);
  std::string damage;
  EXPECT_EQ(decodeImage(file, needed - file.size(), damage), makePhoto(300, 200));
  EXPECT_THROW(decodeImage(file, needed - file.size() - 1, damage), Error);
}

TEST_F(TextureImages, areNotReadIfTheirFilesExceedTheMemory) {
  writeBytes(models_ / "a.png", pngOf(makePhoto(300, 200)));
  std::filesystem::resize_file(models_ / "a.png", 1ull << 36);
  const std::vector<TextureImage> images = surveyed({"a.png"}, 1 << 20);
  EXPECT_NE(images[0].problem.find("needs 68.8GB"), std::string::npos) << images[0].problem;
  EXPECT_TRUE(images[0].needs_memory);
}

TEST_F(TextureImages, areRefusedWithTheirCountAboveTheTileLimit) {
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

TEST_F(TextureImages, areCountedBeforeTheyAreSearched) {
  EXPECT_THROW(surveyed(std::vector<std::string>(kMaxTextures + 1, "a.png")), Error);
}

}  // namespace
}  // namespace lode::ingest
