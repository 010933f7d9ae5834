#include "client/app/cli/common_options.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

#include "client/app/cli/opened_target.h"
#include "client/app/cli/remedy_words.h"
#include "client/core/view/camera_path.h"
#include "common/error.h"
#include "proto/limits.h"
#include "tests/support/work_folder.h"

namespace lode::app {
namespace {

TEST(PictureSize, isWidthTimesHeight) {
  EXPECT_EQ(parseSize("1280x720").width_px, 1280u);
  EXPECT_EQ(parseSize("1280x720").height_px, 720u);
  const std::string most = std::to_string(core::kMaxPictureSidePx);
  EXPECT_EQ(parseSize("1x" + most).height_px, core::kMaxPictureSidePx);
}

TEST(PictureSize, isRefusedIfInvalidOrTooLarge) {
  const std::string too_much = std::to_string(core::kMaxPictureSidePx + 1);
  for (const std::string& text :
       {std::string(), std::string("1280"), std::string("1280x"), std::string("x720"), std::string("0x720"),
        std::string("1280x0"), std::string("-1x5"), std::string("1280X720"), std::string("1280x720x"),
        std::string(" 1x1"), std::string("4294967297x1"), "1x" + too_much, too_much + "x1"})
    EXPECT_THROW(parseSize(text), Error) << text;
}

TEST(CommonOptions, giveTheStreamItsBudget) {
  CommonOptions options;
  options.memory_text = "16M";
  EXPECT_EQ(options.streamOptions().engine.memory_budget_bytes, 16u << 20);
  options.memory_text = "512MB";
  EXPECT_EQ(options.streamOptions().engine.memory_budget_bytes, 512'000'000u);
  options.memory_text = "16777215";
  EXPECT_THROW(options.streamOptions(), Error);
}

TEST(CommonOptions, limitTheConnectTimeoutToTheTimeout) {
  CommonOptions options;
  options.timeout_s = 0.0101;
  EXPECT_EQ(options.timeout().count(), 11);
  EXPECT_EQ(options.streamOptions().connect_timeout.count(), 11);
}

TEST(CommonOptions, takeTheTokenFromAFileWithoutItsLineEnds) {
  const std::string file = testing::TempDir() + "lodestream-token-" + std::to_string(::getpid());
  CommonOptions options;
  options.token_file = file;
  std::ofstream(file) << "secret\r\n";
  EXPECT_EQ(options.streamOptions().engine.session.token, "secret");
  std::ofstream(file) << std::string(proto::kMaxTokenBytes, 'x') << '\n';
  EXPECT_EQ(options.streamOptions().engine.session.token.size(), proto::kMaxTokenBytes);
  std::ofstream(file) << std::string(proto::kMaxTokenBytes + 1, 'x');
  EXPECT_THROW(options.streamOptions(), Error);
  std::remove(file.c_str());
  EXPECT_THROW(options.streamOptions(), Error);
}

TEST(CommonOptions, refuseAFileThatIsNotOneToken) {
  const lode::test::WorkFolder folder;
  CommonOptions options;
  options.token_file = folder / "tokens";
  for (const char* text : {"", "\n", "one never *\ntwo never *\n", "# for guests\none\n", "one never *\n",
                           "one 2027-01-31T12:00:00Z scan\n", "a\tb", "\xff"}) {
    std::ofstream(options.token_file) << text;
    try {
      options.streamOptions();
      ADD_FAILURE() << "taken: " << text;
    } catch (const Error& error) {
      EXPECT_TRUE(std::string(error.what()).starts_with(options.token_file + ": is not one token"))
          << text << ": " << error.what();
    }
  }
}

TEST(CommonOptions, refuseACacheThatIsNoFolder) {
  const lode::test::WorkFolder folder;
  CommonOptions options;
  options.target = "lode://localhost/model";
  options.cache_text = folder / "file";
  std::ofstream(options.cache_text) << "something";
  try {
    options.streamOptions();
    ADD_FAILURE() << "taken";
  } catch (const Error& error) {
    EXPECT_EQ(messageOf(error), options.cache_text + ": is not a folder that only you can write to; remove " +
                                    "it, or give --cache a folder, or off");
  }
}

TEST(CommonOptions, refuseACacheThatNothingCanBeWrittenTo) {
  CommonOptions options;
  options.target = "lode://host/model";
  options.cache_text = "/proc";  // a folder in which not even root can create files
  EXPECT_THROW(options.streamOptions(), Error);
}

TEST(CommonOptions, makeTheFolderOfACache) {
  const lode::test::WorkFolder folder;
  CommonOptions options;
  options.target = "lode://localhost/model";
  options.cache_text = folder / "a/b";
  EXPECT_EQ(options.streamOptions().cache_folder, options.cache_text);
  EXPECT_TRUE(std::filesystem::is_directory(options.cache_text));
}

TEST(CommonOptions, takeATokenWithSpaces) {
  const lode::test::WorkFolder folder;
  CommonOptions options;
  options.token_file = folder / "token";
  std::ofstream(options.token_file) << "correct horse never tires\n";
  EXPECT_EQ(options.streamOptions().engine.session.token, "correct horse never tires");
}

TEST(CommonOptions, setAspectAndUpOfTheFirstCamera) {
  CommonOptions options;
  options.size_text = "800x400";
  EXPECT_EQ(wantedFraming(options).aspect, 2);
  EXPECT_FALSE(wantedFraming(options).up);
  options.up_text = "-z";
  EXPECT_EQ(wantedFraming(options).up, glm::dvec3(0, 0, -1));
  options.up_text = "north";
  EXPECT_THROW(wantedFraming(options), Error);
}

}  // namespace
}  // namespace lode::app
