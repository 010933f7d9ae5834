#include "client/render/gl/image.h"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>

#include <gtest/gtest.h>

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_PNG
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb/stb_image.h>
#pragma GCC diagnostic pop

#include "common/error.h"

namespace lode::render {
namespace {

TEST(WritePng, writesAPictureThatReadsBackUnchanged) {
  Image image{37, 21, {}};
  std::mt19937 random(3);
  for (uint32_t i = 0; i < 37 * 21; ++i) {
    for (int channel = 0; channel < 3; ++channel) image.rgba.push_back(static_cast<uint8_t>(random()));
    image.rgba.push_back(255);
  }
  const auto path = std::filesystem::path(testing::TempDir()) / "lodestream_write_png.png";
  writePng(path, image);
  int width = 0, height = 0, channels = 0;
  stbi_uc* read = stbi_load(path.c_str(), &width, &height, &channels, 4);
  ASSERT_NE(read, nullptr);
  EXPECT_EQ(width, 37);
  EXPECT_EQ(height, 21);
  EXPECT_EQ(channels, 3);
  EXPECT_TRUE(std::equal(image.rgba.begin(), image.rgba.end(), read));
  stbi_image_free(read);
  std::filesystem::remove(path);
}

TEST(WritePng, saysThatItsColoursAreThoseOfSrgb) {
  const auto path = std::filesystem::path(testing::TempDir()) / "lodestream_srgb.png";
  writePng(path, {1, 1, {10, 20, 30, 255}});
  std::ifstream file(path, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  EXPECT_NE(bytes.find("sRGB"), std::string::npos);
  std::filesystem::remove(path);
}

TEST(WritePng, namesTheFileThatCannotBeWritten) {
  try {
    writePng("/nowhere/at/all.png", {1, 1, {0, 0, 0, 255}});
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("/nowhere/at/all.png"), std::string::npos);
  }
}

}  // namespace
}  // namespace lode::render
