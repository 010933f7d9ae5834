// Tests of pictures that are drawn off-screen, and of pictures of the window under a virtual display.

#include "tests/integration/pictures/picture.h"

#include <array>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/integration/programs/models.h"
#include "tests/integration/programs/programs.h"

namespace lode::test {
namespace {

using Json = nlohmann::json;

class Pictures : public testing::TestWithParam<Model> {
 protected:
  void SetUp() override { LODE_REQUIRE_MODEL(GetParam()); }

  WorkFolder folder_;
};

TEST_P(Pictures, areRenderedOffScreenInTheRequestedSize) {
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

TEST(Render, convergesOnTheOriginalTrianglesEvenIfALatticeStepIsVisible) {
  const WorkFolder folder;
  const auto store = makeSmallStore(folder);
  const auto render = [&](const char* pixels) {
    return lodestream({"render", store, "--pixels", pixels, "--json", "-o", folder / "a.png"});
  };
  const Outcome fine = render("0.01");
  if (cannotDraw(fine, "cannot draw off-screen")) GTEST_SKIP() << fine.err;
  EXPECT_EQ(fine.status, 0) << fine.err;
  const Json json = Json::parse(fine.out, nullptr, false);
  EXPECT_EQ(json["converged"], true);
  EXPECT_EQ(json["pictures"], 1);
  EXPECT_GT(json["max_error_px"], 0.01);
  EXPECT_GT(Picture(folder / "a.png").covered(0, 0), 0.1);
  const Outcome coarse = render("1");
  EXPECT_EQ(coarse.status, 0) << coarse.err;
  EXPECT_EQ(Json::parse(coarse.out, nullptr, false)["converged"], true);
}

TEST(Render, printsTheLegendOfTheShownColours) {
  const WorkFolder folder;
  const auto store = makeSmallStore(folder);
  const Outcome outcome =
      lodestream({"render", store, "--show", "lods", "--json", "--size", "64x48", "-o", folder / "a.png"});
  if (cannotDraw(outcome, "cannot draw off-screen")) GTEST_SKIP() << outcome.err;
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  const Json legend = Json::parse(outcome.out, nullptr, false)["legend"];
  ASSERT_FALSE(legend.empty());
  EXPECT_EQ(legend[0]["meaning"].get<std::string>().substr(0, 4), "LOD ");
  EXPECT_EQ(legend[0]["colour"].get<std::string>().substr(0, 1), "#");
}

TEST(Render, refusesInvalidColourModesAndUpAxes) {
  const WorkFolder folder;
  const auto store = makeSmallStore(folder);
  for (const std::vector<std::string>& wrong : {std::vector<std::string>{"--show", "nothing"},
                                                {"--show", "ages"},
                                                {"--up", "north"},
                                                {"--unlit", "--show", "lods"}}) {
    std::vector<std::string> arguments{"render", store, "-o", folder / "a.png"};
    arguments.insert(arguments.end(), wrong.begin(), wrong.end());
    const Outcome outcome = lodestream(arguments);
    if (cannotDraw(outcome, "cannot draw off-screen")) GTEST_SKIP() << outcome.err;
    EXPECT_EQ(outcome.status, 2) << wrong[0] << ": " << outcome.err;
    expectOneLine(outcome.err);
  }
}

TEST(Render, framesAnotherViewForAnotherUpAxis) {
  const WorkFolder folder;
  const auto store = makeSmallStore(folder);
  for (const char* up : {"y", "z"}) {
    const Outcome outcome = lodestream(
        {"render", store, "--up", up, "--size", "64x48", "-o", folder / (std::string(up) + ".png")});
    if (cannotDraw(outcome, "cannot draw off-screen")) GTEST_SKIP() << outcome.err;
    ASSERT_EQ(outcome.status, 0) << outcome.err;
  }
  EXPECT_NE(Picture(folder / "y.png").pixels, Picture(folder / "z.png").pixels);
}

TEST(Render, lightsAModelIndependentlyOfTheUpVectorOfCameras) {
  const WorkFolder folder;
  const auto store = makeSmallStore(folder);
  const std::string looks = R"({"keys": [{"eye": [1, 2, 5], "target": [0, 0, 0], "up": )";
  const auto picture = [&](const std::string& name, const std::string& camera_up, const std::string& up) {
    writeBytes(folder / (name + ".json"), looks + camera_up + "}]}");
    return lodestream({"render", store, "--camera", folder / (name + ".json"), "--up", up, "--size", "64x48",
                       "-o", folder / (name + ".png")});
  };
  for (const Outcome& outcome : {picture("upright", "[0, 1, 0]", "y"), picture("along", "[-1, 3, -5]", "y"),
                                 picture("other", "[0, 1, 0]", "-y")}) {
    if (cannotDraw(outcome, "cannot draw off-screen")) GTEST_SKIP() << outcome.err;
    ASSERT_EQ(outcome.status, 0) << outcome.err;
  }
  EXPECT_EQ(Picture(folder / "upright.png").pixels, Picture(folder / "along.png").pixels);
  EXPECT_NE(Picture(folder / "upright.png").pixels, Picture(folder / "other.png").pixels);
}

TEST(Window, showsAModelUnderAVirtualDisplay) {
  const Model& painted = models()[2];
  LODE_REQUIRE_MODEL(painted);
  const WorkFolder folder;
  const auto file = folder / "a.png";
  const std::string lodestream = LODE_BIN_DIR "/bin/lodestream";
  Program program("xvfb-run", {"-a", "-s", "-screen 0 1024x1024x24", lodestream, "view", painted.store(),
                               "--size", "1000x800", "--screenshot", file});
  const Outcome outcome = program.wait();
  if (outcome.status == 127) GTEST_SKIP() << "no xvfb-run: install xvfb";
  ASSERT_EQ(outcome.status, 0) << outcome.out << outcome.err;
  const Picture picture(file);
  ASSERT_EQ(picture.width_px, 1000);
  ASSERT_EQ(picture.height_px, 800);
  EXPECT_GT(picture.covered(500, 400), 0.1);  // the area right of the panel and below it
  EXPECT_LT(picture.covered(500, 400), 0.9);
}

TEST(Window, refusesAScreenshotWithoutThePngEnding) {
  const WorkFolder folder;
  const auto store = makeSmallStore(folder);
  const Outcome outcome = lodestream({"view", store, "--screenshot", folder / "a.jpg"});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_NE(outcome.err.find("give it the ending .png"), std::string::npos) << outcome.err;
}

TEST(Window, refusesAScreenshotOverItsModel) {
  const WorkFolder folder;
  std::filesystem::rename(makeSmallStore(folder), folder / "model.png");
  const Outcome outcome =
      lodestream({"view", folder / "model.png", "--screenshot", folder / "model.png"}, {"DISPLAY="});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_NE(outcome.err.find("is the input"), std::string::npos) << outcome.err;
}

TEST(Window, refusesAScreenshotOfAFlight) {
  const WorkFolder folder;
  const Outcome outcome = lodestream(
      {"view", makeSmallStore(folder), "--laps", "1", "--screenshot", (folder / "a.png").string()});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_NE(outcome.err.find("excludes"), std::string::npos) << outcome.err;
}

TEST(Render, refusesOutputsWithoutThePngEndingAndOverItsModel) {
  const WorkFolder folder;
  const auto store = makeSmallStore(folder);
  std::filesystem::copy_file(store, folder / "model.png");
  const std::array<std::array<std::string, 2>, 3> refused{{{folder / "a.jpg", "give it the ending .png"},
                                                           {folder.path(), ".png"},
                                                           {folder / "model.png", "is the input"}}};
  for (const auto& [output, why] : refused) {
    const Outcome outcome = lodestream({"render", folder / "model.png", "--size", "32x32", "-o", output});
    if (cannotDraw(outcome, "cannot draw off-screen")) GTEST_SKIP() << outcome.err;
    EXPECT_EQ(outcome.status, 2);
    EXPECT_NE(outcome.err.find(why), std::string::npos) << outcome.err;
  }
  EXPECT_EQ(readBytes(folder / "model.png"), readBytes(store));
}

TEST(Render, acceptsThePngEndingInCapitals) {
  const WorkFolder folder;
  const Outcome outcome =
      lodestream({"render", makeSmallStore(folder), "--size", "32x24", "-o", folder / "a.PNG"});
  if (cannotDraw(outcome, "cannot draw off-screen")) GTEST_SKIP() << outcome.err;
  EXPECT_EQ(Picture(folder / "a.PNG").width_px, 32) << outcome.err;
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
