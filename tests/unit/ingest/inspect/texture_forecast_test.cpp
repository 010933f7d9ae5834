#include "server/ingest/inspect/texture_forecast.h"

#include <gtest/gtest.h>

#include "server/ingest/disk/temporary_folder.h"
#include "server/ingest/textures/textures.h"
#include "tests/support/work_folder.h"
#include "tests/unit/ingest/textures/image_files.h"

namespace lode::ingest {
namespace {

using test::makePhoto;
using test::pngOf;
using test::writeBytes;

constexpr uint64_t kMemoryBytes = 1ull << 30;

class ForecastTextures : public testing::Test {
 protected:
  std::vector<TextureImage> surveyed(const std::vector<std::string>& names) const {
    return surveyTextures(imagesOf(folder_ / "a.ply", names), {}, kMemoryBytes);
  }

  /// Bytes that a build writes in the stage "textures".
  uint64_t stagedBytes(const std::vector<TextureImage>& images) const {
    BuildOptions options;
    options.input = folder_ / "a.ply";
    options.memory_bytes = kMemoryBytes;
    options.threads = 1;
    const TemporaryFolder files(folder_.path());
    Spool tiles(files.file("tiles"));
    stageTextures(options, images, {}, tiles, kMemoryBytes, {});
    return tiles.size();
  }

  test::WorkFolder folder_;
};

TEST_F(ForecastTextures, estimatesTheSizeOfTilesWithinHalf) {
  writeBytes(folder_ / "large.png", pngOf(makePhoto(2600, 1500)));
  writeBytes(folder_ / "clear.png", pngOf(makePhoto(700, 900, true)));
  writeBytes(folder_ / "small.png", pngOf(makePhoto(40, 30)));
  for (const char* name : {"large.png", "clear.png", "small.png"}) {
    const std::vector<TextureImage> images = surveyed({name});
    const auto forecast = static_cast<double>(forecastTextures(images, kMemoryBytes, 1).tile_bytes);
    const auto staged = static_cast<double>(stagedBytes(images));
    EXPECT_LE(forecast, 1.5 * staged) << name;
    EXPECT_GE(forecast, staged / 1.5) << name;
  }
}

TEST_F(ForecastTextures, countsEachImageInBytesAndTheLargestInMemory) {
  writeBytes(folder_ / "a.png", pngOf(makePhoto(1200, 1100)));
  const TextureForecast one = forecastTextures(surveyed({"a.png"}), kMemoryBytes, 1);
  const TextureForecast four =
      forecastTextures(surveyed({"a.png", "a.png", "a.png", "a.png"}), kMemoryBytes, 1);
  EXPECT_NEAR(static_cast<double>(four.tile_bytes), 4 * static_cast<double>(one.tile_bytes), 4);
  EXPECT_EQ(four.memory_bytes, one.memory_bytes);
  EXPECT_GE(one.memory_bytes, uint64_t{1200} * 1100 * 5);
  EXPECT_GT(forecastTextures(surveyed({"a.png"}), kMemoryBytes, 3).memory_bytes, one.memory_bytes);
}

TEST_F(ForecastTextures, countsNothingForImagesThatAreLeftOut) {
  writeBytes(folder_ / "a.png", pngOf(makePhoto(100, 100)));
  const std::vector<TextureImage> images =
      surveyTextures(imagesOf(folder_ / "a.ply", std::vector<std::string>{"a.png", "gone.png"}), {}, 1000);
  const TextureForecast forecast = forecastTextures(images, kMemoryBytes, 1);
  EXPECT_EQ(forecast.tile_bytes, 0u);
  EXPECT_EQ(forecast.memory_bytes, 0u);
  EXPECT_EQ(forecast.serial_cpu_seconds, 0);
}

}  // namespace
}  // namespace lode::ingest
