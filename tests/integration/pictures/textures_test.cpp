// Tests of textured models, from the PLY file and its image to the picture.

#include <algorithm>
#include <cmath>
#include <sstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "server/store/reader.h"
#include "tests/integration/pictures/picture.h"

namespace lode::test {
namespace {

constexpr int kImagePx = 2048, kSquarePx = 128, kWidthPx = 400, kHeightPx = 300;
constexpr double kFovYDeg = 45;

/// Returns the colour of a texel's square, one bit per channel. Neighbouring squares have different colours.
unsigned colourAt(double x_px, double y_px) {
  const auto column = static_cast<unsigned>(x_px / kSquarePx), row = static_cast<unsigned>(y_px / kSquarePx);
  return (column * 3 + row * 5) % 7 + 1;
}

void writeCheckered(const std::filesystem::path& file) {
  std::vector<uint8_t> pixels;
  for (int y = 0; y < kImagePx; ++y)
    for (int x = 0; x < kImagePx; ++x)
      for (unsigned channel = 0; channel < 3; ++channel)
        pixels.push_back((colourAt(x, y) >> channel & 1) != 0 ? 255 : 0);
  writePicture(file, kImagePx, kImagePx, pixels);
}

/// A flat sheet of 2 x 2 units with many triangles; texture coordinates go from -0.5 to 1.5, v upwards.
class CheckeredSheet : public testing::Test {
 protected:
  void SetUp() override {
    constexpr int kCells = 96;
    std::ostringstream vertices, faces;
    for (int row = 0; row <= kCells; ++row)
      for (int column = 0; column <= kCells; ++column) {
        const double x = 2.0 * column / kCells, y = 2.0 * row / kCells;
        vertices << x << ' ' << y << " 0 " << x - 0.5 << ' ' << y - 0.5 << '\n';
      }
    for (int row = 0; row < kCells; ++row)
      for (int column = 0; column < kCells; ++column) {
        const int a = row * (kCells + 1) + column, b = a + kCells + 1;
        faces << "4 " << a << ' ' << a + 1 << ' ' << b + 1 << ' ' << b << '\n';
      }
    std::ostringstream ply;
    ply << "ply\nformat ascii 1.0\ncomment TextureFile checkered sheet.png\nelement vertex "
        << (kCells + 1) * (kCells + 1)
        << "\nproperty float x\nproperty float y\nproperty float z\nproperty float s\nproperty float t\n"
        << "element face " << kCells * kCells << "\nproperty list uchar int vertex_indices\nend_header\n"
        << vertices.str() << faces.str();
    writeBytes(folder_ / "sheet.ply", ply.str());
    writeCheckered(folder_ / "checkered sheet.png");
    const Outcome built = lodestreamd({"build", folder_ / "sheet.ply", "-o", folder_ / "sheet.lode",
                                       "--triangles-per-node", "1024", "--quiet"});
    ASSERT_EQ(built.status, 0) << built.err;
  }

  /// A camera straight above a point of the sheet.
  std::filesystem::path cameraAbove(double x, double y, double height) const {
    const nlohmann::json path = {
        {"fov_y_deg", kFovYDeg},
        {"keys", {{{"t", 0}, {"eye", {x, y, height}}, {"target", {x, y, 0}}, {"up", {0, 1, 0}}}}}};
    writeBytes(folder_ / "camera.json", path.dump());
    return folder_ / "camera.json";
  }

  std::vector<std::string> arguments(const char* command, const std::filesystem::path& camera) const {
    return {command,    folder_ / "sheet.lode",
            "--camera", camera,
            "--size",   std::to_string(kWidthPx) + "x" + std::to_string(kHeightPx)};
  }

  /// Numbers of all pixels well inside a square of the image, and of those with another colour.
  struct Comparison {
    int pixels = 0, wrong = 0;
  };
  /// @param coarser  extra level-0 texels that a drawn texel may cover.
  static Comparison compare(const Picture& picture, double x, double y, double height, double coarser = 0) {
    const double pixel = 2 * height * std::tan(kFovYDeg / 360 * 3.14159265358979) / kHeightPx;
    // Margin in texels, for filtering and lossy tiles.
    const double margin_px = 4 + 2 * pixel * kImagePx + coarser;
    Comparison result;
    for (int row = 0; row < kHeightPx; ++row)
      for (int column = 0; column < kWidthPx; ++column) {
        const double at_x = x + (column + 0.5 - kWidthPx / 2.0) * pixel;
        const double at_y = y - (row + 0.5 - kHeightPx / 2.0) * pixel;
        if (std::min(at_x, at_y) < 2 * pixel || std::max(at_x, at_y) > 2 - 2 * pixel) continue;
        const double u = at_x - 0.5, v = at_y - 0.5;
        const double texel_x = (u - std::floor(u)) * kImagePx, texel_y = (1 - (v - std::floor(v))) * kImagePx;
        const double in_x = std::fmod(texel_x, kSquarePx), in_y = std::fmod(texel_y, kSquarePx);
        if (std::min({in_x, in_y, kSquarePx - in_x, kSquarePx - in_y}) < margin_px) continue;
        ++result.pixels;
        unsigned shown = 0;
        for (unsigned channel = 0; channel < 3; ++channel)
          shown |= (picture.pixel(column, row)[channel] > 128 ? 1u : 0u) << channel;
        result.wrong += shown != colourAt(texel_x, texel_y);
      }
    return result;
  }

  WorkFolder folder_;
};

struct Standpoint {
  const char* name;
  double x, y, height;
};

class CheckeredSheetFrom : public CheckeredSheet, public testing::WithParamInterface<Standpoint> {};

TEST_P(CheckeredSheetFrom, showsEachSquareInItsPlaceAndColour) {
  const auto [name, x, y, height] = GetParam();
  std::vector<std::string> render = arguments("render", cameraAbove(x, y, height));
  render.insert(render.end(), {"-o", folder_ / "a.png"});
  const Outcome outcome = lodestream(render);
  if (cannotDraw(outcome, "cannot draw off-screen")) GTEST_SKIP() << outcome.err;
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const Picture picture(folder_ / "a.png");
  ASSERT_EQ(picture.width_px, kWidthPx);
  const Comparison comparison = compare(picture, x, y, height);
  EXPECT_GE(comparison.pixels, 3000);
  EXPECT_EQ(comparison.wrong, 0);
}

INSTANTIATE_TEST_SUITE_P(Place, CheckeredSheetFrom,
                         testing::Values(Standpoint{"NearABorderOfTiles", 0.5 + 508.0 / 2048, 0.9, 0.15},
                                         Standpoint{"NearTheImagesCorner", 0.5, 0.5, 0.3},
                                         Standpoint{"Before", 0.9, 1.1, 0.8},
                                         Standpoint{"FromAfar", 1, 1, 3}),
                         [](const auto& place) { return place.param.name; });

TEST_F(CheckeredSheet, isFetchedWithTheTilesThatTheCameraNeeds) {
  const auto fetch = [this](double height) {
    std::vector<std::string> command = arguments("fetch", cameraAbove(0.75, 0.9, height));
    command.push_back("--json");
    const Outcome outcome = lodestream(command);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return nlohmann::json::parse(outcome.out);
  };
  const nlohmann::json near_by = fetch(0.1), far_off = fetch(20);
  for (const nlohmann::json& json : {near_by, far_off}) {
    EXPECT_TRUE(json["converged"]);
    EXPECT_EQ(json["tiles_left_out"], 0);
    EXPECT_LT(json["texture_bytes"], json["bytes_received"]);
  }
  EXPECT_EQ(far_off["tiles"], 1);
  EXPECT_GT(near_by["tiles"], 4);
  EXPECT_GT(near_by["texture_bytes"], far_off["texture_bytes"]);
}

class DamagedSheet : public CheckeredSheet {
 protected:
  void SetUp() override {
    CheckeredSheet::SetUp();
    if (HasFatalFailure()) return;
    const std::filesystem::path file = folder_ / "sheet.lode";
    std::string bytes = readBytes(file);
    const store::Reader store(file);
    for (const BlobRef& tile : store.textures().textures[0].tiles)
      bytes[store.blob(tile.number).offset + tile.bytes / 2] ^= 1;
    writeBytes(file, bytes);
  }

  /// Expects success with a warning that names the missing part and the reason.
  static nlohmann::json expectNotConverged(const Outcome& outcome) {
    EXPECT_EQ(outcome.status, 1);
    EXPECT_NE(outcome.err.find("did not converge"), std::string::npos) << outcome.err;
    EXPECT_NE(outcome.err.find("the server says"), std::string::npos) << outcome.err;
    const nlohmann::json told = nlohmann::json::parse(outcome.out);
    EXPECT_FALSE(told["converged"]);
    EXPECT_GT(told["tiles_lost"], 0);
    EXPECT_NE(outcome.err.find(told["failure"].get<std::string>()), std::string::npos) << told;
    return told;
  }
};

TEST_F(DamagedSheet, isFetchedWithoutItsTilesAndDoesNotConverge) {
  std::vector<std::string> fetch = arguments("fetch", cameraAbove(0.75, 0.9, 0.1));
  fetch.insert(fetch.end(), {"--json", "-o", folder_ / "cut.ply"});
  const Outcome outcome = lodestream(fetch);
  const nlohmann::json told = expectNotConverged(outcome);
  EXPECT_EQ(told["tiles"], 0);
  EXPECT_FALSE(told["finest"]) << "what it lacks is no finer mesh";
  EXPECT_TRUE(std::filesystem::exists(folder_ / "cut.ply"));
  EXPECT_NE(outcome.err.find("left out, because it is unavailable"), std::string::npos) << outcome.err;
  EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 1) << outcome.err;
  EXPECT_EQ(outcome.err.find("--memory-budget"), std::string::npos) << outcome.err;
}

TEST_F(DamagedSheet, isFetchedForEachKeyOfItsPath) {
  nlohmann::json path = nlohmann::json::parse(readBytes(cameraAbove(0.75, 0.9, 0.1)));
  path["keys"].push_back(path["keys"][0]);
  path["keys"][1]["t"] = 1;
  writeBytes(folder_ / "camera.json", path.dump());
  std::vector<std::string> fetch = arguments("fetch", folder_ / "camera.json");
  fetch.emplace_back("--json");
  EXPECT_EQ(expectNotConverged(lodestream(fetch))["keys"].size(), 2u);
}

TEST_F(DamagedSheet, isReplayedToTheEndAndDoesNotConverge) {
  std::vector<std::string> replay = arguments("replay", cameraAbove(0.75, 0.9, 0.1));
  replay.emplace_back("--json");
  expectNotConverged(lodestream(replay));
}

TEST_F(DamagedSheet, isDrawnWithoutItsTilesAndDoesNotConverge) {
  std::vector<std::string> render = arguments("render", cameraAbove(0.75, 0.9, 0.1));
  render.insert(render.end(), {"--json", "-o", folder_ / "a.png"});
  const Outcome outcome = lodestream(render);
  if (cannotDraw(outcome, "cannot draw off-screen")) GTEST_SKIP() << outcome.err;
  EXPECT_EQ(expectNotConverged(outcome)["pictures"], 1);
  EXPECT_EQ(Picture(folder_ / "a.png").width_px, kWidthPx);
}

TEST_F(DamagedSheet, isDrawnInASceneAndDoesNotConverge) {
  makeSmallStore(folder_);
  writeBytes(folder_ / "scene.json",
             R"({"models": {"sheet": "sheet.lode", "small": "small.lode"},
                 "instances": [{"model": "sheet", "position": [0, 0, 0]},
                               {"model": "small", "position": [0, 0, -1]}]})");
  const Outcome outcome = lodestream({"render", folder_ / "scene.json", "--json", "--camera",
                                      cameraAbove(0.75, 0.9, 8), "-o", folder_ / "a.png"});
  if (cannotDraw(outcome, "cannot draw off-screen")) GTEST_SKIP() << outcome.err;
  EXPECT_EQ(expectNotConverged(outcome)["pictures"], 1);
}

TEST_F(CheckeredSheet, isFetchedWithItsImageBesideTheMesh) {
  std::vector<std::string> fetch = arguments("fetch", cameraAbove(0.75, 0.9, 0.1));
  fetch.insert(fetch.end(), {"-o", folder_ / "cut.obj"});
  const Outcome outcome = lodestream(fetch);
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_NE(readBytes(folder_ / "cut.mtl").find("map_Kd cut_checkered sheet.png\n"), std::string::npos);
  const Picture image(folder_ / "cut_checkered sheet.png");
  ASSERT_EQ(image.width_px, kImagePx);
  int wrong = 0;
  for (int y = kSquarePx / 2; y < kImagePx; y += kSquarePx)
    for (int x = kSquarePx / 2; x < kImagePx; x += kSquarePx)
      for (unsigned channel = 0; channel < 3; ++channel)
        wrong += (image.pixel(x, y)[channel] > 128) != ((colourAt(x, y) >> channel & 1) != 0);
  EXPECT_EQ(wrong, 0);
}

TEST_F(CheckeredSheet, isFetchedFromAfarWithACoarseImage) {
  std::vector<std::string> fetch = arguments("fetch", cameraAbove(0.75, 0.9, 20));
  fetch.insert(fetch.end(), {"-o", folder_ / "cut.glb"});
  const Outcome outcome = lodestream(fetch);
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_NE(readBytes(folder_ / "cut.glb").find("cut_checkered%20sheet.png"), std::string::npos);
  EXPECT_EQ(Picture(folder_ / "cut_checkered sheet.png").width_px, kImagePx / 8);
}

TEST_F(CheckeredSheet, isShownInCoarserTilesWhereMemoryIsShort) {
  std::vector<std::string> fetch = arguments("fetch", cameraAbove(0.9, 0.9, 0.5));
  std::vector<std::string> render = arguments("render", cameraAbove(0.9, 0.9, 0.5));
  fetch.insert(fetch.end(), {"--memory-budget", "16M", "--json"});
  render.insert(render.end(), {"--memory-budget", "16M", "-o", folder_ / "a.png"});
  const Outcome fetched = lodestream(fetch);
  ASSERT_EQ(fetched.status, 0) << fetched.err;
  const nlohmann::json json = nlohmann::json::parse(fetched.out);
  EXPECT_TRUE(json["converged"]);
  EXPECT_GT(json["tiles_left_out"], 0);
  EXPECT_GT(json["tiles"], 0);
  const Outcome outcome = lodestream(render);
  if (cannotDraw(outcome, "cannot draw off-screen")) GTEST_SKIP() << outcome.err;
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(compare(Picture(folder_ / "a.png"), 0.9, 0.9, 0.5, 8).wrong, 0);
}

}  // namespace
}  // namespace lode::test
