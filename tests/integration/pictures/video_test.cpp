// Tests of videos that fail: a signal interrupts the drawing, or the video would overwrite its model.

#include <csignal>
#include <filesystem>

#include <gtest/gtest.h>

#include "tests/integration/pictures/picture.h"
#include "tests/integration/programs/programs.h"

namespace lode::test {
namespace {

namespace fs = std::filesystem;

TEST(InterruptedVideo, leavesNoFrames) {
  const WorkFolder folder;
  const fs::path ply = folder / "a.ply", path = folder / "path.json", ffmpeg = folder / "ffmpeg";
  ASSERT_EQ(lodestreamd({"sample", "asteroid", "--triangles", "1000", "-o", ply}).status, 0);
  const Outcome picture = lodestream({"render", ply, "--size", "64x64", "-o", folder / "a.png"});
  if (cannotDraw(picture, "cannot draw off-screen")) GTEST_SKIP() << picture.err;
  writeBytes(path, R"({"keys": [{"t": 0, "eye": [3, 0, 0], "target": [0, 0, 0], "up": [0, 0, 1]},
                                {"t": 600, "eye": [0, 3, 0], "target": [0, 0, 0], "up": [0, 0, 1]}]})");
  writeBytes(ffmpeg, "#!/bin/sh\n");
  fs::permissions(ffmpeg, fs::perms::owner_all);
  const fs::path frames = folder / "out.mp4.frames";
  Program program("lodestream",
                  {"render", ply, "--camera", path, "--size", "160x120", "--video", folder / "out.mp4"},
                  {"PATH=" + folder.path().string(), "XDG_CACHE_HOME=" + (folder / "cache").string()});
  waitForFile(frames, "/frame_000000.png");
  program.signal(SIGINT);
  const Outcome outcome = program.wait();
  EXPECT_EQ(outcome.status, 128 + SIGINT);
  EXPECT_NE(outcome.err.find("interrupted; unfinished output is removed"), std::string::npos) << outcome.err;
  EXPECT_FALSE(fs::exists(frames));
}

TEST(Video, isNeverWrittenOverItsModel) {
  const WorkFolder folder;
  const fs::path ply = folder / "a.ply";
  ASSERT_EQ(lodestreamd({"sample", "asteroid", "--triangles", "1000", "-o", ply}).status, 0);
  const auto before = fs::file_size(ply);
  const Outcome outcome = lodestream({"render", ply, "--video", ply});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_NE(outcome.err.find("is the input"), std::string::npos) << outcome.err;
  EXPECT_EQ(fs::file_size(ply), before);
}

}  // namespace
}  // namespace lode::test
