#include "client/app/window/output/picture_file.h"

#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "common/error.h"
#include "tests/support/work_folder.h"

namespace lode::app {
namespace {

TEST(PictureFile, mayBeTheFileOfStandardOutput) {
  testing::internal::CaptureStdout();  // into a file without an ending
  EXPECT_NO_THROW(checkPictureFile("a.lode", "/dev/stdout"));
  testing::internal::GetCapturedStdout();
}

TEST(PictureFile, needsThePngEndingUnlessItIsADevice) {
  const test::WorkFolder folder;
  EXPECT_NO_THROW(checkPictureFile("a.lode", folder / "a.png"));
  EXPECT_NO_THROW(checkPictureFile("a.lode", "/dev/null"));
  EXPECT_THROW(checkPictureFile("a.lode", folder / "a.jpg"), Error);
}

TEST(FilmFolder, isRefusedWhereFramesOfALongerFilmLie) {
  const test::WorkFolder work;
  makeFilmFolder(work / "a" / "b");
  const auto folder = work / "a" / "b";
  for (const char* name : {"frame_000000.png", "frame_000002.png", "frame_9.png", "frames.png"})
    std::ofstream(folder / name) << "x";
  EXPECT_NO_THROW(refuseOtherFilm(folder, 3));
  try {
    refuseOtherFilm(folder, 2);
    FAIL() << "not refused";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("frame_000002.png belongs to another film"), std::string::npos)
        << error.what();
  }
}

TEST(FilmFolder, namesAFrameThatHasMoreDigits) { EXPECT_EQ(frameName(1'000'000), "frame_1000000.png"); }

}  // namespace
}  // namespace lode::app
