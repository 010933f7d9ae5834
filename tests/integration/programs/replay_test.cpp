// Tests of replay, which follows a camera path in real time and reports on it.

#include <array>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "programs.h"

namespace lode::test {
namespace {

using Json = nlohmann::json;

std::string writePath(const WorkFolder& folder, double seconds = 1) {
  const auto key = [](double t, double x, double z) {
    return Json{{"t", t}, {"eye", {x, 0.3, z}}, {"target", {0, 0, 0}}, {"up", {0, 1, 0}}};
  };
  const Json path{{"fov_y_deg", 45}, {"keys", {key(0, 0, 5), key(seconds / 2, 2, 2), key(seconds, 1.3, 0)}}};
  writeBytes(folder / "path.json", path.dump());
  return folder / "path.json";
}

TEST(Replay, movesInRealTimeWithoutAHoleAndConvergesAtTheEnd) {
  const WorkFolder folder;
  const RunningServer server({makeSmallStore(folder)});
  const Outcome outcome = lodestream({"replay", server.url("small"), "--camera", writePath(folder),
                                      "--pixels", "2", "--fps", "100", "--json"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  const Json json = Json::parse(outcome.out, nullptr, false);
  EXPECT_EQ(json.value("converged", false), true);
  EXPECT_GE(json["frames"], 50);
  EXPECT_EQ(json["holes"], 0);
  for (const char* key : {"first_image_ms", "converged_ms", "bytes_received", "final_cut_bytes",
                          "resident_bytes", "peak_rss_bytes"})
    EXPECT_GT(json[key], 0) << key;
  EXPECT_GE(json["converged_ms"], 1000);
  EXPECT_LE(json["max_error_px"], 2);
  EXPECT_GE(json["seconds_above_px"]["1"], json["seconds_above_px"]["4"]);
  EXPECT_GE(json["prefetch"]["requested"], json["prefetch"]["used"]);
  EXPECT_TRUE(json["limited_by"].is_string());
  EXPECT_GT(json["waited_s"]["link"], 0);
  EXPECT_EQ(json["waited_s"]["budget"], 0);
  EXPECT_GT(json["link"]["round_trip_ms"], 0);
}

TEST(Replay, reachesAnErrorWhileTheCameraMoves) {
  const WorkFolder folder;
  const RunningServer server({makeSmallStore(folder)});
  constexpr double kPathSeconds = 4;
  const Outcome outcome = lodestream({"replay", server.url("small"), "--camera",
                                      writePath(folder, kPathSeconds), "--pixels", "2", "--json"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_LT(Json::parse(outcome.out)["reached_px_ms"]["4"], 1000 * kPathSeconds);
}

TEST(Replay, prefetchesNothingWithNoPrefetch) {
  const WorkFolder folder;
  const RunningServer server({makeSmallStore(folder)});
  const Outcome outcome = lodestream({"replay", server.url("small"), "--camera", writePath(folder),
                                      "--no-prefetch", "--order", "first-come", "--pixels", "2", "--json"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(Json::parse(outcome.out)["prefetch"]["requested"], 0);
}

TEST(Replay, recordsATraceThatALoadTestReplays) {
  const WorkFolder folder;
  const RunningServer server({makeSmallStore(folder)});
  const std::string trace = folder / "trace.json";
  EXPECT_EQ(lodestream({"replay", server.url("small"), "--camera", writePath(folder), "--pixels", "2",
                        "--record", trace})
                .status,
            0);
  const Outcome outcome = lodestream(
      {"loadtest", server.url("small"), "--trace", trace, "--clients", "3", "--seconds", "2", "--json"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  const Json json = Json::parse(outcome.out);
  EXPECT_EQ(json["errors"], 0);
  ASSERT_EQ(json["traces"].size(), 1u);
  EXPECT_EQ(json["traces"][0]["seconds"], 1);
  EXPECT_GT(json["traces"][0]["requests"], 5);
  EXPECT_GT(json["latency_ms"]["visible"]["count"], 0);
}

/// A trace of the small model. A test may change the file of the trace.
class ReplayedTrace : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(
        lodestream({"replay", store_, "--camera", writePath(folder_), "--pixels", "2", "--record", trace_})
            .status,
        0);
  }
  Outcome loadtest() const {
    return lodestream({"loadtest", store_, "--trace", trace_, "--clients", "1", "--seconds", "1"});
  }

  const WorkFolder folder_;
  const std::string store_ = makeSmallStore(folder_), trace_ = folder_ / "trace.json";
};

TEST_F(ReplayedTrace, isRefusedIfItIsOfAnotherBuild) {
  ASSERT_EQ(
      lodestreamd({"build", folder_ / "small.ply", "-o", store_, "--triangles-per-node", "512", "--quiet"})
          .status,
      0);
  expectFailure(loadtest(), {trace_, "another build of the model", "replay --record"});
}

TEST_F(ReplayedTrace, isRefusedWithoutRequests) {
  Json trace = Json::parse(readBytes(trace_));
  trace["requests"] = Json::array();
  writeBytes(trace_, trace.dump());
  expectFailure(loadtest(), {trace_, "no requests to replay"});
}

TEST(Replay, refusesToRecordATraceOverItsInput) {
  const WorkFolder folder;
  const std::string store = makeSmallStore(folder), path = writePath(folder);
  for (const std::string& input : {store, path}) {
    const auto before = readBytes(input);
    const Outcome outcome = lodestream({"replay", store, "--camera", path, "--record", input});
    EXPECT_EQ(outcome.status, 2) << outcome.err;
    EXPECT_TRUE(readBytes(input) == before) << input;
  }
}

TEST(Replay, failsBeforeAnyWorkIfTheTraceCannotBeWritten) {
  const WorkFolder folder;
  const std::string store = makeSmallStore(folder);
  const Outcome outcome =
      lodestream({"replay", store, "--camera", writePath(folder, 1e6), "--record", folder.path().string()});
  EXPECT_EQ(outcome.status, 2) << outcome.err;
  expectOneLine(outcome.err);
}

TEST(Replay, keepsTheOldTraceWhenInterrupted) {
  const WorkFolder folder;
  const std::string store = makeSmallStore(folder), trace = folder / "trace.json";
  writeBytes(trace, "an older one");
  Program program("lodestream", {"replay", store, "--camera", writePath(folder, 1e6), "--record", trace});
  waitForFile(folder.path(), ".tmp");
  program.signal(SIGINT);
  EXPECT_EQ(program.wait().status, 128 + SIGINT);
  EXPECT_EQ(readBytes(trace), "an older one");
}

TEST(Replay, saysWhyItDidNotConverge) {
  const WorkFolder folder;
  const RunningServer server({makeSmallStore(folder)}, {"--max-rate", "2KB"});
  const Outcome outcome = lodestream(
      {"replay", server.url("small"), "--camera", writePath(folder), "--pixels", "0.01", "--timeout", "2"});
  EXPECT_EQ(outcome.status, 1) << outcome.out;
  expectOneLine(outcome.err);
}

}  // namespace
}  // namespace lode::test
