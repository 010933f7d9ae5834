#include "client/loadtest/load_report.h"

#include <chrono>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace lode::app {
namespace {

using Json = nlohmann::ordered_json;

class LoadReport : public testing::Test {
 protected:
  LoadReport() {
    options_.clients = 30;
    options_.seconds = result_.seconds = 4;
  }
  std::string text() const { return describe(options_, result_); }
  Json json() const { return toJson(options_, plans_, result_, 0); }
  bool says(const std::string& part) const { return text().find(part) != std::string::npos; }

  LoadOptions options_;
  std::vector<LoadPlan> plans_{1};
  LoadResult result_;
};

TEST_F(LoadReport, printsHowManyClientsHadStartedIfNotAll) {
  result_.counts.started = 4;
  EXPECT_TRUE(says("4 of 30 clients had begun")) << text();
}

TEST_F(LoadReport, printsTheNumberOfClientsIfAllHadStarted) {
  result_.counts.started = 30;
  EXPECT_TRUE(says(" 30 clients,")) << text();
}

TEST_F(LoadReport, printsNoTimesWithoutRequests) { EXPECT_TRUE(says("visible requests: none")) << text(); }

TEST_F(LoadReport, hasNullPercentilesWithoutRequests) {
  const Json nothing{{"count", 0}, {"p50", nullptr}, {"p90", nullptr}, {"p99", nullptr}, {"max", nullptr}};
  EXPECT_EQ(json()["latency_ms"]["visible"], nothing);
}

TEST_F(LoadReport, hasPercentilesOfASingleRequest) {
  result_.counts.latency[0].add(std::chrono::milliseconds(7));
  EXPECT_EQ(json()["latency_ms"]["visible"]["p50"], 7.0);
}

TEST_F(LoadReport, saysWhenItWasInterrupted) {
  result_.interrupted = true;
  result_.seconds = 1.5;
  EXPECT_TRUE(says("interrupted after 1.5 of 4 s")) << text();
  EXPECT_EQ(json()["interrupted"], true);
}

TEST_F(LoadReport, dividesBytesByTheTimeThatTheTestTook) {
  result_.seconds = 0.5;
  result_.counts.bytes = 1'000'000;
  EXPECT_TRUE(says("2.0 MB/s")) << text();
}

}  // namespace
}  // namespace lode::app
