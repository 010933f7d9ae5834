// Tests of scenes that are drawn off-screen.

#include <optional>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/integration/pictures/picture.h"
#include "tests/integration/programs/programs.h"

namespace lode::test {
namespace {

constexpr const char* kCamera =
    R"({"keys": [{"t": 0, "eye": [0, -4, 1], "target": [0, 0, 0], "up": [0, 0, 1]}]})";

class Scenes : public testing::Test {
 protected:
  void SetUp() override { writeBytes(folder_ / "camera.json", kCamera); }

  std::string withInstances(const std::string& instances, const std::string& more = "") const {
    return R"({"models": {"m": ")" + store_.string() + R"("}, "instances": [)" + instances + "]" + more + "}";
  }
  Picture render(const std::string& name, const std::filesystem::path& target,
                 const std::string& camera = "camera.json") {
    std::vector<std::string> arguments{"render", target,    "--camera", folder_ / camera,
                                       "--size", "160x120", "-o",       folder_ / (name + ".png")};
    // The scenes have the same up axis.
    if (target.extension() != ".json") arguments.insert(arguments.end(), {"--up", "z"});
    const Outcome outcome = lodestream(arguments);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return Picture(folder_ / (name + ".png"));
  }
  Picture renderScene(const std::string& name, const std::string& scene,
                      const std::string& camera = "camera.json") {
    writeBytes(folder_ / (name + ".json"), scene);
    return render(name, folder_ / (name + ".json"), camera);
  }
  /// Returns the largest difference of a channel. Ignores the `but_for` most different pixels.
  static int difference(const Picture& a, const Picture& b, size_t but_for) {
    std::vector<int> worst;
    for (size_t i = 0; i < a.pixels.size() && i < b.pixels.size(); ++i)
      worst.push_back(std::abs(int{a.pixels[i]} - int{b.pixels[i]}));
    std::ranges::sort(worst, std::greater());
    return worst.size() > 3 * but_for ? worst[3 * but_for] : 255;
  }

  const std::filesystem::path store_ = std::filesystem::path(LODE_BIN_DIR) / "test-models" / "painted.lode";
  WorkFolder folder_;
};

class DrawnScenes : public Scenes {
 protected:
  void SetUp() override {
    Scenes::SetUp();
    const Outcome tried = lodestream({"render", store_, "--camera", folder_ / "camera.json", "--size",
                                      "16x16", "-o", folder_ / "tried.png"});
    if (cannotDraw(tried, "cannot draw off-screen")) GTEST_SKIP() << tried.err;
  }
};

TEST_F(DrawnScenes, equalThePictureOfTheirOnlyModel) {
  const Picture model = render("model", store_);
  const Picture scene = renderScene("scene", withInstances(R"({"model": "m"})"));
  EXPECT_GT(model.covered(0, 0), 0.1);
  EXPECT_EQ(difference(model, scene, 0), 0);
}

TEST_F(DrawnScenes, equalThePictureOfTheirOnlyModelFromCloseBy) {
  writeBytes(folder_ / "close.json",
             R"({"keys": [{"t": 0, "eye": [0, -1.5, 0.2], "target": [0, 0, 0], "up": [0, 0, 1]}]})");
  const Picture model = render("model", store_, "close.json");
  EXPECT_GT(model.covered(0, 0), 0.5);
  EXPECT_EQ(difference(model, renderScene("scene", withInstances(R"({"model": "m"})"), "close.json"), 0), 0);
}

TEST_F(DrawnScenes, lookTheSameIfModelAndCameraAreTransformedTogether) {
  // The camera is turned by 90 degrees about z, scaled by 2 and moved aside.
  writeBytes(folder_ / "moved.json",
             R"({"keys": [{"t": 0, "eye": [18, 20, 32], "target": [10, 20, 30], "up": [0, 0, 1]}]})");
  const Picture model = render("model", store_);
  const Picture moved = renderScene(
      "scene",
      withInstances(
          R"({"model": "m", "position": [10, 20, 30], "axis": [0, 0, 1], "degrees": 90, "scale": 2})"),
      "moved.json");
  EXPECT_LE(difference(model, moved, 20), 6);
}

TEST_F(DrawnScenes, hideFartherInstancesInAnyOrderAndAtAnyScale) {
  const std::string near = R"({"model": "m", "position": [0, -1, 0], "scale": 0.5})";
  const std::string far = R"({"model": "m", "position": [0.5, 6, 0], "scale": 3})";
  const std::string near_first = near + "," + far, far_first = far + "," + near;
  for (const std::string ground : {"", R"(, "ground": {"height": -0.4, "colour": "#408040"})"}) {
    const Picture one = renderScene("one", withInstances(near_first, ground));
    const Picture other = renderScene("other", withInstances(far_first, ground));
    EXPECT_EQ(difference(one, other, 0), 0);
    const Picture near_alone = renderScene("near", withInstances(near, ground));
    for (int x = 76; x < 84; ++x)
      EXPECT_EQ(one.pixel(x, 60)[0], near_alone.pixel(x, 60)[0]) << "the near one, in the middle";
    const uint8_t* const below = one.pixel(5, 115);
    EXPECT_EQ(below[1] > below[0] + 20 && below[1] > below[2] + 20, !ground.empty());
  }
}

TEST_F(DrawnScenes, darkenTheGroundUnderAStandingModelOnly) {
  const auto on = [](const char* colour) {
    return std::string(R"(, "ground": {"height": -1, "colour": ")") + colour + R"("})";
  };
  const std::string model = R"({"model": "m"})";
  const Picture green = renderScene("green", withInstances(model, on("#40a040")));
  const Picture red = renderScene("red", withInstances(model, on("#a04040")));
  const Picture above =
      renderScene("above", withInstances(R"({"model": "m", "position": [0, 0, 50]})", on("#40a040")));
  int darker = 0;
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 160; ++x) {
      const uint8_t *const a = green.pixel(x, y), *const b = red.pixel(x, y);
      const bool is_ground = a[1] > a[0] + 20 && b[0] > b[1] + 20;
      darker += is_ground && a[1] + 15 < above.pixel(x, y)[1];
    }
  }
  EXPECT_GT(darker, 200);
}

TEST_F(DrawnScenes, lookTheSameInTheWindowWithSeveralServers) {
  ASSERT_EQ(lodestreamd({"sample", "scene", "--triangles", "3000", "-o", folder_ / "s"}).status, 0);
  const std::filesystem::path rock = folder_ / "s" / "rock.lode", file = folder_ / "s" / "scene.json";
  ASSERT_EQ(lodestreamd({"build", folder_ / "s" / "rock.ply", "-o", rock}).status, 0);
  RunningServer server({rock});
  auto scene = nlohmann::json::parse(readBytes(file));
  scene["models"]["rock"] = server.url("rock");
  writeBytes(file, scene.dump());
  const Outcome drawn = lodestream({"render", file, "--size", "1000x700", "-o", folder_ / "render.png"});
  if (cannotDraw(drawn, "cannot draw off-screen")) GTEST_SKIP() << drawn.err;
  ASSERT_EQ(drawn.status, 0) << drawn.err;
  const std::string viewer = std::string(LODE_BIN_DIR) + "/bin/lodestream";
  Program program("xvfb-run", {"-a", "-s", "-screen 0 1024x1024x24", viewer, "view", file, "--size",
                               "1000x700", "--pixels", "1", "--screenshot", folder_ / "window.png"});
  const Outcome outcome = program.wait();
  if (outcome.status == 127) GTEST_SKIP() << "no xvfb-run: install xvfb";
  ASSERT_EQ(outcome.status, 0) << outcome.out << outcome.err;
  const Picture window(folder_ / "window.png"), render(folder_ / "render.png");
  size_t other = 0, looked_at = 0;
  for (int y = 0; y < 700; ++y) {
    for (int x = 400; x < 1000; ++x, ++looked_at) {  // right of the panel
      const uint8_t *const a = window.pixel(x, y), *const b = render.pixel(x, y);
      other += std::abs(a[0] - b[0]) > 8 || std::abs(a[1] - b[1]) > 8 || std::abs(a[2] - b[2]) > 8;
    }
  }
  EXPECT_LT(static_cast<double>(other), 1e-3 * static_cast<double>(looked_at));
  EXPECT_GT(render.shades(), 50u) << "there is something to see";
}

/// Returns the last frame of a flight in the window; nothing if there is no display.
std::optional<uint64_t> trianglesOfLastFrame(const std::filesystem::path& scene,
                                             const std::filesystem::path& camera) {
  const std::string viewer = std::string(LODE_BIN_DIR) + "/bin/lodestream";
  Program program("xvfb-run", {"-a", "-s", "-screen 0 640x480x24", viewer, "view", scene, "--camera", camera,
                               "--size", "320x240", "--pixels", "1", "--laps", "1", "--json"});
  const Outcome outcome = program.wait();
  if (outcome.status == 127) return {};
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  return nlohmann::json::parse(outcome.out)["frames"].back()["triangles"].get<uint64_t>();
}

TEST_F(DrawnScenes, leaveOutOccludedInstancesInTheWindow) {
  writeBytes(folder_ / "flight.json",
             R"({"keys": [{"t": 0, "eye": [0, -4, 1], "target": [0, 0, 0], "up": [0, 0, 1]},
                          {"t": 1, "eye": [0.01, -4, 1], "target": [0, 0, 0], "up": [0, 0, 1]}]})");
  const auto triangles = [&](const std::string& name, const std::string& other) {
    writeBytes(folder_ / name, withInstances(R"({"model": "m"})" + other));
    return trianglesOfLastFrame(folder_ / name, folder_ / "flight.json");
  };
  const auto alone = triangles("alone.json", "");
  if (!alone) GTEST_SKIP() << "no xvfb-run: install xvfb";
  const auto beside = triangles("beside.json", R"(, {"model": "m", "position": [2, 4, -1], "scale": 0.3})");
  const auto behind = triangles("behind.json", R"(, {"model": "m", "position": [0, 4, -1], "scale": 0.3})");
  EXPECT_GT(*beside, *alone + *alone / 10) << "there is nothing to leave out";
  EXPECT_LE(*behind, *alone + *alone / 50);
}

TEST_F(DrawnScenes, areRefusedInOneLineWhereTheyAreWrong) {
  const auto refusal = [&](const std::string& scene) {
    writeBytes(folder_ / "s.json", scene);
    const Outcome outcome = lodestream({"render", folder_ / "s.json", "-o", folder_ / "a.png"});
    EXPECT_NE(outcome.status, 0);
    expectOneLine(outcome.err);
    return outcome.err;
  };
  EXPECT_NE(refusal("{").find("s.json"), std::string::npos);
  EXPECT_NE(refusal(R"({"models": {"m": "no.lode"}, "instances": [{"model": "m"}]})").find("no.lode"),
            std::string::npos);
}

TEST_F(DrawnScenes, refuseTheOptionUp) {
  writeBytes(folder_ / "s.json", withInstances(R"({"model": "m"})"));
  const Outcome outcome = lodestream({"render", folder_ / "s.json", "--up", "y", "-o", folder_ / "a.png"});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_NE(outcome.err.find("leave out --up"), std::string::npos) << outcome.err;
}

TEST_F(Scenes, areRefusedByCommandsThatTakeOneModel) {
  writeBytes(folder_ / "s.json", withInstances(R"({"model": "m"})"));
  const Outcome fetched =
      lodestream({"fetch", folder_ / "s.json", "--camera", folder_ / "camera.json", "-o", folder_ / "a.ply"});
  EXPECT_EQ(fetched.status, 2);
  EXPECT_NE(fetched.err.find("is a scene"), std::string::npos) << fetched.err;
}

TEST_F(Scenes, madeBySampleAreReproducibleWithAHundredInstances) {
  for (const char* name : {"a", "b"}) {
    const Outcome made = lodestreamd({"sample", "scene", "--triangles", "3000", "-o", folder_ / name});
    ASSERT_EQ(made.status, 0) << made.err;
  }
  EXPECT_EQ(readBytes(folder_ / "a" / "scene.json"), readBytes(folder_ / "b" / "scene.json"));
  const auto scene = nlohmann::json::parse(readBytes(folder_ / "a" / "scene.json"));
  EXPECT_GE(scene["instances"].size(), 100u);
  EXPECT_GE(scene["models"].size(), 3u);
  EXPECT_NE(lodestreamd({"sample", "scene", "--triangles", "3000", "-o", folder_ / "a"}).status, 0);
}

TEST(HelpOfDrawingCommands, mentionsScenesAsTargets) {
  for (const char* command : {"view", "render"})
    EXPECT_NE(lodestream({command, "--help"}).out.find("a scene"), std::string::npos) << command;
}

}  // namespace
}  // namespace lode::test
