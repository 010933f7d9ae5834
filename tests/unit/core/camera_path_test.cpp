#include "client/core/view/camera_path.h"

#include <gtest/gtest.h>

#include "common/error.h"

namespace lode::core {
namespace {

std::string keyAt(const std::string& t, const std::string& eye) {
  return R"({"t": )" + t + R"(, "eye": )" + eye + R"(, "target": [0,0,0], "up": [0,1,0]})";
}

std::string pathOf(const std::string& keys) { return R"({"fov_y_deg": 60, "keys": [)" + keys + "]}"; }

void expectRefused(const std::string& json, const std::string& part_of_message) {
  try {
    parseCameraPath(json, "path.json");
    FAIL() << "not refused: " << json.substr(0, 100);
  } catch (const Error& error) {
    const std::string message = error.what();
    EXPECT_EQ(message.find("path.json: "), 0u) << message;
    EXPECT_NE(message.find(part_of_message), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

TEST(CameraPath, readsTheDocumentedFormat) {
  const CameraPath path =
      parseCameraPath(pathOf(keyAt("0", "[0,0,5]") + "," + keyAt("2.5", "[1e6,0,5.5]")), "p");
  EXPECT_EQ(path.fov_y_deg, 60);
  ASSERT_EQ(path.keys.size(), 2u);
  EXPECT_EQ(path.keys[1].t, 2.5);
  EXPECT_EQ(path.keys[1].eye, glm::dvec3(1e6, 0, 5.5));
}

TEST(CameraPath, hasAFieldOfViewOf45DegreesIfNoneIsGiven) {
  EXPECT_EQ(parseCameraPath(R"({"keys": [)" + keyAt("0", "[0,0,5]") + "]}", "p").fov_y_deg, 45);
}

TEST(CameraPath, refusesMembersThatItDoesNotKnowAndNamesThem) {
  const std::string good = keyAt("0", "[0,0,5]");
  expectRefused(R"({"fov": 60, "keys": [)" + good + "]}", R"(has no member "fov")");
  expectRefused(pathOf(R"({"eye": [0,0,5], "target": [0,0,0], "upp": [0,0,1]})"),
                R"(keys[0] has no member "upp")");
  expectRefused(R"({"a\nb": 60, "keys": [)" + good + "]}", R"(has no member "a\nb")");
}

TEST(CameraPath, refusesAnInvalidCameraPathAndNamesThePlace) {
  const std::string good = keyAt("0", "[0,0,5]");
  expectRefused("", "not JSON");
  expectRefused("{", "not JSON");
  expectRefused("[1]", "not a JSON object");
  expectRefused(R"({"fov_y_deg": 45})", "keys");
  expectRefused(pathOf(""), "keys");
  expectRefused(pathOf("5"), "keys[0] is not an object");
  expectRefused(pathOf(good + ",7"), "keys[1] is not an object");
  expectRefused(pathOf(keyAt("0", "[0,0]")), "keys[0].eye");
  expectRefused(pathOf(keyAt("0", R"([0,0,"x"])")), "keys[0].eye");
  expectRefused(pathOf(keyAt("0", "[0,0,1e300]")), "must be from -1e15 to 1e15");
  expectRefused(pathOf(keyAt("\"0\"", "[0,0,5]")), "keys[0].t");
  expectRefused(pathOf(R"({"t": 0, "eye": [0,0,5]})"), "keys[0].target is missing");
  expectRefused(pathOf(keyAt("0", "[0,0,0]")), "looks from the target");
  expectRefused(pathOf(keyAt("0", "[0,4,0]")), "up points along");
  expectRefused(pathOf(R"({"eye": [0,0,5], "target": [0,0,0], "up": [0,0,0]})"), "up must not be zero");
  expectRefused(pathOf(good + "," + keyAt("0", "[0,0,6]")), "keys[1].t is not after");
  expectRefused(pathOf(R"({"eye": [0,0,5], "target": [0,0,0]},)" + good), "keys[0].t is missing");
  expectRefused(R"({"fov_y_deg": 0, "keys": [)" + good + "]}", "fov_y_deg");
  expectRefused(R"({"fov_y_deg": 180, "keys": [)" + good + "]}", "fov_y_deg");
}

TEST(CameraPath, refusesDeepNestingWithoutOverflowingTheStack) {
  expectRefused(std::string(200'000, '['), "not JSON");
}

TEST(CameraPath, refusesATextLongerThanTheLimit) {
  expectRefused(std::string(kMaxCameraPathBytes + 1, ' '), "limit");
}

TEST(CameraPath, refusesMoreKeysThanTheLimit) {
  std::string keys = "0";
  for (size_t i = 0; i < kMaxCameraKeys; ++i) keys += ",0";
  expectRefused(pathOf(keys), "limit");
}

TEST(CameraPath, namesAFileThatCannotBeOpened) {
  try {
    readCameraPath("/no/such/file.json");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kIo);
    EXPECT_NE(std::string(error.what()).find("/no/such/file.json"), std::string::npos);
  }
}

CameraPath straightLine() {
  CameraPath path;
  for (int i = 0; i < 4; ++i)
    path.keys.push_back({double(i) * (i + 1), {double(i) * (i + 1) * 3, 0, 10}, {0, 0, 0}, {0, 1, 0}});
  return path;
}

TEST(CameraPath, passesThroughItsKeysAndStandsStillBeyondThem) {
  const CameraPath path = straightLine();
  for (const CameraKey& key : path.keys) EXPECT_EQ(cameraAt(path, key.t), key);
  EXPECT_EQ(cameraAt(path, -1), path.keys.front());
  EXPECT_EQ(cameraAt(path, 99), path.keys.back());
}

TEST(CameraPath, movesEvenlyAlongALineThatIsEvenInTime) {
  const CameraPath path = straightLine();
  for (double t = 0.05; t < 12; t += 0.1) EXPECT_NEAR(cameraAt(path, t).eye.x, 3 * t, 1e-9);
}

TEST(CameraPath, movesWithoutJumpsOfSpeed) {
  CameraPath path = straightLine();
  path.keys[1].eye = {5, 7, 1};
  const auto speedAt = [&](double t) {
    return (cameraAt(path, t + 1e-6).eye - cameraAt(path, t - 1e-6).eye) / 2e-6;
  };
  const double t = path.keys[1].t;
  EXPECT_LT(glm::length(speedAt(t - 1e-5) - speedAt(t + 1e-5)), 1e-2);
}

TEST(CameraPath, givesAViewRelativeToTheLatticesOriginInDouble) {
  ModelSummary model;
  model.lattice = {{1e9, 2e9, 3e9}, 1};
  const CameraKey key{0, {1e9 + 0.25, 2e9, 3e9 + 5}, {1e9 + 0.25, 2e9, 3e9}, {0, 2, 1}};
  const View view = toView(key, 45, 640, 480, model);
  EXPECT_EQ(view.eye_model, glm::dvec3(0.25, 0, 5));
  EXPECT_EQ(view.forward, glm::dvec3(0, 0, -1));
  EXPECT_NEAR(glm::dot(view.up, view.forward), 0, 1e-12);
  EXPECT_NEAR(glm::length(view.up), 1, 1e-12);
}

TEST(CameraPath, findsAnUpWhereInterpolationLeavesNone) {
  const View view = toView({0, {0, 0, 0}, {0, 5, 0}, {0, 1, 0}}, 45, 640, 480, ModelSummary{});
  EXPECT_NEAR(glm::dot(view.up, view.forward), 0, 1e-12);
  EXPECT_NEAR(glm::length(view.up), 1, 1e-12);
}

}  // namespace
}  // namespace lode::core
