// Pictures: drawn off-screen, and of the window under a display that is not there.

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "tests/integration/programs/models.h"
#include "tests/integration/programs/programs.h"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#define STBI_ONLY_PNG
#include <stb/stb_image.h>
#pragma GCC diagnostic pop

namespace lode::test {
namespace {

/// A picture read back from its file.
struct Picture {
  int width_px = 0, height_px = 0;
  std::vector<uint8_t> pixels;  ///< three bytes each

  explicit Picture(const std::filesystem::path& file) {
    int channels = 0;
    stbi_uc* const read = stbi_load(file.c_str(), &width_px, &height_px, &channels, 3);
    if (read == nullptr) return;
    pixels.assign(read, read + static_cast<size_t>(width_px) * height_px * 3);
    stbi_image_free(read);
  }

  const uint8_t* pixel(int x, int y) const {
    return pixels.data() + (static_cast<size_t>(y) * width_px + x) * 3;
  }
  /// Of a part of the picture, from a corner to the picture's lower right one: how much is not background.
  /// That is nearly one colour a row: it is dithered.
  double covered(int left, int top) const {
    constexpr int kDither = 8;
    size_t drawn = 0;
    for (int y = top; y < height_px; ++y)
      for (int x = left; x < width_px; ++x) {
        int difference = 0;
        for (int c = 0; c < 3; ++c)
          difference = std::max(difference, std::abs(pixel(x, y)[c] - pixel(width_px - 1, y)[c]));
        drawn += difference > kDither;
      }
    return static_cast<double>(drawn) / ((width_px - left) * (height_px - top));
  }
  /// Levels of red in its middle row.
  size_t shades() const {
    std::set<uint8_t> seen;
    for (int x = 0; x < width_px; ++x) seen.insert(*pixel(x, height_px / 2));
    return seen.size();
  }
};

bool cannotDraw(const Outcome& outcome, const char* why) {
  return outcome.status == 1 && outcome.err.find(why) != std::string::npos;
}

class Pictures : public testing::TestWithParam<Model> {
 protected:
  void SetUp() override { LODE_REQUIRE_MODEL(GetParam()); }

  WorkFolder folder_;
};

TEST_P(Pictures, areRenderedOffScreenInTheSizeAskedForAndNotEmpty) {
  const auto file = folder_ / "a.png";
  const Outcome outcome = lodestream({"render", GetParam().store(), "--size", "320x200", "-o", file});
  if (cannotDraw(outcome, "cannot draw off-screen")) GTEST_SKIP() << outcome.err;
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  EXPECT_TRUE(readBytes(file).starts_with("\x89PNG\r\n\x1a\n"));
  const Picture picture(file);
  ASSERT_EQ(picture.width_px, 320);
  ASSERT_EQ(picture.height_px, 200);
  EXPECT_GT(picture.covered(0, 0), 0.1);
  EXPECT_LT(picture.covered(0, 0), 0.9);
  EXPECT_GT(picture.shades(), 20u);
}

INSTANTIATE_TEST_SUITE_P(Of, Pictures, testing::Values(models()[0], models()[2]), nameOf);

TEST(Render, drawsBackgroundAloneWithTheModelBehindTheCamera) {
  const WorkFolder folder;
  const auto store = makeSmallStore(folder);
  writeBytes(folder / "away.json",
             R"({"keys": [{"t": 0, "eye": [0, 0, 5], "target": [0, 0, 10], "up": [0, 1, 0]}]})");
  const Outcome outcome = lodestream(
      {"render", store, "--camera", folder / "away.json", "--size", "64x48", "-o", folder / "a.png"});
  if (cannotDraw(outcome, "cannot draw off-screen")) GTEST_SKIP() << outcome.err;
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const Picture picture(folder / "a.png");
  ASSERT_EQ(picture.height_px, 48);
  EXPECT_EQ(picture.covered(0, 0), 0);
}

TEST(Window, showsAModelUnderAVirtualDisplay) {
  const Model& painted = models()[2];
  LODE_REQUIRE_MODEL(painted);
  const WorkFolder folder;
  const auto file = folder / "a.png";
  Program program("xvfb-run", {"-a", "-s", "-screen 0 1024x1024x24", LODE_BIN_DIR "/bin/lodestream", "view",
                               painted.store(), "--size", "1000x800", "--screenshot", file});
  const Outcome outcome = program.wait();
  if (outcome.status == 127) GTEST_SKIP() << "no xvfb-run: install xvfb";
  ASSERT_EQ(outcome.status, 0) << outcome.out << outcome.err;
  const Picture picture(file);
  ASSERT_EQ(picture.width_px, 1000);
  ASSERT_EQ(picture.height_px, 800);
  EXPECT_GT(picture.covered(500, 400), 0.1);  // right of the panel and below it
  EXPECT_LT(picture.covered(500, 400), 0.9);
}

TEST(Render, failsWithOneLineIfItsPictureCannotBeWritten) {
  const WorkFolder folder;
  const auto store = makeSmallStore(folder);
  const auto before = folder.contents();
  const Outcome outcome =
      lodestream({"render", store, "--size", "32x32", "-o", folder / "missing" / "a.png"});
  if (cannotDraw(outcome, "cannot draw off-screen")) GTEST_SKIP() << outcome.err;
  expectFailure(outcome, {"missing/a.png"});
  EXPECT_EQ(folder.contents(), before);
}

}  // namespace
}  // namespace lode::test
