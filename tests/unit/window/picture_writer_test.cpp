#include "client/app/window/output/picture_writer.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "common/error.h"
#include "tests/support/work_folder.h"

namespace lode::app {
namespace {

namespace fs = std::filesystem;

render::Image greyPicture(uint32_t width_px) { return {width_px, 2, std::vector<uint8_t>(8 * width_px, 77)}; }

TEST(PictureWriter, reportsEachPictureOnceInOrder) {
  const test::WorkFolder folder;
  PictureWriter writer;
  EXPECT_FALSE(writer.take());
  const fs::path first = folder / "first.png", second = folder / "second.png";
  writer.write(first, greyPicture(300));
  writer.write(second, greyPicture(1));
  for (const fs::path& file : {first, second}) {
    const auto written = writer.waitAndTake();
    ASSERT_TRUE(written);
    EXPECT_EQ(written->file, file);
    EXPECT_EQ(written->failure, nullptr);
    EXPECT_GT(fs::file_size(file), 8u);
  }
  EXPECT_FALSE(writer.waitAndTake());
}

TEST(PictureWriter, reportsWhyAPictureCouldNotBeWritten) {
  const test::WorkFolder folder;
  PictureWriter writer;
  writer.write(folder / "no folder" / "picture.png", greyPicture(1));
  const auto written = writer.waitAndTake();
  ASSERT_TRUE(written);
  ASSERT_NE(written->failure, nullptr);
  EXPECT_THROW(std::rethrow_exception(written->failure), Error);
}

TEST(PictureWriter, writesWithoutBlockingItsCaller) {
  const test::WorkFolder folder;
  PictureWriter writer;
  writer.write(folder / "large.png", {2000, 2000, std::vector<uint8_t>(4u * 2000 * 2000, 77)});
  EXPECT_FALSE(writer.take()) << "the picture takes many times longer to compress than this call";
  const auto written = writer.waitAndTake();
  ASSERT_TRUE(written);
  EXPECT_EQ(written->failure, nullptr);
}

TEST(PictureWriter, refusesAPipeInsteadOfWaitingForItsReader) {
  const test::WorkFolder folder;
  const fs::path pipe = folder / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  PictureWriter writer;
  writer.write(pipe, greyPicture(1));
  const auto written = writer.waitAndTake();
  ASSERT_TRUE(written);
  EXPECT_NE(written->failure, nullptr);
}

using std::chrono::milliseconds;

constexpr PictureRequest::TimePoint kStart{};

TEST(PictureRequest, isTakenOnceWhenTheWindowIsAtRest) {
  PictureRequest request;
  EXPECT_FALSE(request.take(true, kStart)) << "before anyone asks";
  request.ask(kStart);
  EXPECT_FALSE(request.take(false, kStart + milliseconds(100)));
  EXPECT_TRUE(request.take(true, kStart + milliseconds(200)));
  EXPECT_FALSE(request.take(true, kStart + milliseconds(300)));
}

TEST(PictureRequest, isTakenAfterTwoSecondsWhateverMoves) {
  PictureRequest request;
  request.ask(kStart);
  EXPECT_FALSE(request.take(false, kStart + milliseconds(1999)));
  EXPECT_TRUE(request.take(false, kStart + milliseconds(2000)));
}

TEST(PictureRequest, waitsNoLongerWhereTheKeyIsHeld) {
  PictureRequest request;
  request.ask(kStart);
  request.ask(kStart + milliseconds(1500));
  EXPECT_TRUE(request.take(false, kStart + milliseconds(2000)));
}

}  // namespace
}  // namespace lode::app
