#include "client/app/window/output/video.h"

#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "client/app/cli/child_process.h"
#include "common/error.h"
#include "tests/support/work_folder.h"

namespace lode::app {
namespace {

namespace fs = std::filesystem;

/// A program that replaces the encoder.
fs::path fakeFfmpeg(const fs::path& folder, const std::string& script) {
  fs::create_directories(folder);
  const fs::path program = folder / "ffmpeg";
  std::ofstream(program) << "#!/bin/sh\n" << script;
  fs::permissions(program, fs::perms::owner_all);
  return program;
}

std::string contentOf(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

constexpr const char* kWriteArguments = "for last; do :; done; echo \"$*\" > \"$last\"\n";

TEST(Video, isMadeByTheFirstFfmpegOfTheSearchPath) {
  const test::WorkFolder work;
  const fs::path second = fakeFfmpeg(work / "b", "");
  fakeFfmpeg(work / "c", "");
  fs::create_directories(work / "a");
  const std::string path = (work / "a").string() + "::" + (work / "b").string() + ":" + (work / "c").string();
  EXPECT_EQ(findFfmpeg(path), second);
}

TEST(Video, failsWithAdviceWithoutFfmpeg) {
  try {
    findFfmpeg("/nowhere:");
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("--frames"), std::string::npos);
  }
}

TEST(Video, isMadeOfAFoldersFramesAtTheirRate) {
  const test::WorkFolder work;
  fs::create_directory(work / "frames");
  makeVideo(fakeFfmpeg(work / "bin", kWriteArguments), work / "frames", 29.97, work / "out.mp4");
  const std::string arguments = contentOf(work / "out.mp4");
  EXPECT_NE(arguments.find("-framerate 29.97 -i " + (work / "frames").string() + "/frame_%06d.png"),
            std::string::npos)
      << arguments;
}

TEST(Video, usesAbsolutePathsWithoutPatternsOrOptions) {
  for (const char* name : {"100%d", "-y", "concat:a"}) {
    const test::WorkFolder work;
    fs::create_directory(work / name);
    makeVideo(fs::relative(fakeFfmpeg(work / "bin", kWriteArguments)), fs::relative(work / name), 30,
              work / "out.mp4");
    const std::string arguments = contentOf(work / "out.mp4");
    const std::string expected = std::string_view(name) == "100%d" ? "100%%d" : name;
    EXPECT_NE(arguments.find(" -i /"), std::string::npos) << arguments;
    EXPECT_NE(arguments.find("/" + expected + "/frame_%06d.png"), std::string::npos) << arguments;
    EXPECT_NE(arguments.find(" -f mp4 /"), std::string::npos) << arguments;
  }
}

TEST(Video, hasTheColoursOfItsFramesAndSaysInWhichMatrix) {
  fs::path ffmpeg;
  try {
    const char* const search_path = std::getenv("PATH");
    ffmpeg = findFfmpeg(search_path != nullptr ? search_path : "");
  } catch (const Error& error) {
    GTEST_SKIP() << error.what();
  }
  const test::WorkFolder work;
  const auto run = [&](const std::vector<std::string>& arguments) {
    ChildProcess program(ffmpeg, arguments, ChildProcess::Messages::kKeep);
    EXPECT_EQ(program.wait(), 0) << program.lastMessage();
  };
  run({"-loglevel", "error", "-f", "lavfi", "-i", "color=0x20a040:size=64x64,format=rgb24", "-frames:v", "2",
       work / "frame_%06d.png"});
  makeVideo(ffmpeg, work.path(), 30, work / "out.mp4");
  run({"-loglevel", "error", "-i", work / "out.mp4", "-frames:v", "1", "-f", "rawvideo", "-pix_fmt", "rgb24",
       work / "said"});
  run({"-loglevel", "error", "-i", work / "out.mp4", "-frames:v", "1", "-vf", "scale=in_color_matrix=bt709",
       "-f", "rawvideo", "-pix_fmt", "rgb24", work / "guessed"});
  for (const char* const file : {"said", "guessed"}) {
    const std::string pixels = contentOf(work / file);
    ASSERT_EQ(pixels.size(), 3u * 64 * 64);
    EXPECT_NEAR(static_cast<uint8_t>(pixels[0]), 0x20, 3) << file;
    EXPECT_NEAR(static_cast<uint8_t>(pixels[1]), 0xa0, 3) << file;
    EXPECT_NEAR(static_cast<uint8_t>(pixels[2]), 0x40, 3) << file;
  }
}

TEST(Video, leavesNothingBehindWhereFfmpegFailsAndSaysWhy) {
  const test::WorkFolder work;
  fs::create_directory(work / "frames");
  const fs::path ffmpeg =
      fakeFfmpeg(work / "bin", std::string(kWriteArguments) + "echo 'no codec' >&2; exit 1");
  try {
    makeVideo(ffmpeg, work / "frames", 30, work / "out.mp4");
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("no codec"), std::string::npos);
  }
  EXPECT_EQ(work.contents(), (std::vector<std::string>{"bin", "bin/ffmpeg", "frames"}));
}

}  // namespace
}  // namespace lode::app
