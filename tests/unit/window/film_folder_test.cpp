#include "client/app/window/output/film_folder.h"

#include <fstream>

#include <gtest/gtest.h>

#include "common/error.h"
#include "tests/support/work_folder.h"

namespace lode::app {
namespace {

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
    EXPECT_NE(std::string(error.what()).find("frame_000002.png is of another film"), std::string::npos)
        << error.what();
  }
}

TEST(FilmFolder, namesAFrameThatHasMoreDigits) { EXPECT_EQ(frameName(1'000'000), "frame_1000000.png"); }

}  // namespace
}  // namespace lode::app
