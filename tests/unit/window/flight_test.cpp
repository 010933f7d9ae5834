#include "client/app/window/flight.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace lode::app {
namespace {

/// Two seconds along x; the path's clock starts at 10.
core::CameraPath somePath() {
  core::CameraPath path;
  path.keys = {{10, {0, 0, 5}, {0, 0, 0}, {0, 1, 0}}, {12, {4, 0, 5}, {4, 0, 0}, {0, 1, 0}}};
  return path;
}

TEST(Flight, fliesItsPathFromTheFirstKeyInEachLapAndEnds) {
  Flight flight(somePath(), 2);
  for (const double start : {0.0, 2.0}) {
    EXPECT_NEAR(flight.cameraAt(start)->eye.x, 0, 1e-9);
    EXPECT_NEAR(flight.cameraAt(start + 1)->eye.x, 2, 1e-9);
  }
  EXPECT_FALSE(flight.cameraAt(4.001));
}

TEST(Flight, endsEvenIfItsPathHasOneKey) {
  core::CameraPath path = somePath();
  path.keys.pop_back();
  Flight flight(path, 1);
  EXPECT_TRUE(flight.cameraAt(0));
  EXPECT_FALSE(flight.cameraAt(1));
}

TEST(Flight, reportsTheMedianThe99thPercentileAndTheMaximumOfEachLap) {
  Flight flight(somePath(), 2);
  flight.cameraAt(0.5);
  for (int i = 1; i <= 200; ++i) {
    const auto number = static_cast<uint64_t>(i);
    flight.draw(number, {.upload_ms = 1, .threshold_px = 2, .triangles = 10});
    flight.finish(number, i);
  }
  flight.cameraAt(2.5);
  flight.draw(201, {});
  flight.finish(201, 7);
  const nlohmann::ordered_json json = flight.toJson();
  EXPECT_EQ(json["laps"].size(), 2u);
  EXPECT_EQ(json["laps"][0]["work_ms"],
            (nlohmann::ordered_json{{"p50", 100.0}, {"p99", 198.0}, {"max", 200.0}}));
  EXPECT_EQ(json["laps"][0]["frames"], 200);
  EXPECT_EQ(json["laps"][1]["work_ms"]["p50"], 7.0);
  EXPECT_EQ(json["frames"].size(), 201u);
  EXPECT_EQ(json["frames"][0]["t"], 10.5);
  EXPECT_NE(flight.describe().find("lap 1: 200 frames; frame time 100.0 ms median, 198.0 ms 99th"),
            std::string::npos);
}

TEST(Flight, assignsLateWorkTimesToTheirFrames) {
  Flight flight(somePath(), 1);
  flight.cameraAt(0);
  flight.draw(0, {.triangles = 1});
  flight.draw(1, {.triangles = 2});
  flight.finish(0, 30);
  flight.finish(1, 40);
  const nlohmann::ordered_json json = flight.toJson();
  EXPECT_EQ(json["frames"][0]["work_ms"], 30.0);
  EXPECT_EQ(json["frames"][1]["triangles"], 2);
  EXPECT_EQ(json["frames"][1]["work_ms"], 40.0);
}

TEST(Flight, reportsTheMedianTargetOfItsFrames) {
  Flight flight(somePath(), 1);
  flight.cameraAt(0);
  for (const uint64_t number : {0, 1, 2}) {
    flight.draw(number, {.target_ms = number == 0 ? 100.0 : 25.0});
    flight.finish(number, 20);
  }
  EXPECT_NE(flight.describe().find("target frame time 25.0 ms"), std::string::npos);
}

/// Simulates a timer that reports frames from before the flight while the flight's frames are pending.
TEST(Flight, ignoresFramesDrawnBeforeIt) {
  Flight flight(somePath(), 1);
  flight.cameraAt(0);
  flight.draw(4, {.triangles = 1});
  for (const uint64_t before : {0, 1, 2, 3}) flight.finish(before, 500);
  flight.finish(4, 30);
  const nlohmann::ordered_json json = flight.toJson();
  EXPECT_EQ(json["frames"].size(), 1u);
  EXPECT_EQ(json["frames"][0]["work_ms"], 30.0);
}

TEST(Flight, ignoresTheFrameDrawnAfterItsEnd) {
  Flight flight(somePath(), 1);
  flight.cameraAt(0);
  flight.draw(0, {});
  flight.cameraAt(2.001);
  flight.draw(1, {});
  flight.finish(0, 30);
  flight.finish(1, 40);
  EXPECT_EQ(flight.toJson()["laps"].size(), 1u);
}

}  // namespace
}  // namespace lode::app
