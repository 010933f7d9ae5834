// Many clients from one process: what loadtest says of a server that answers, and of one that does not.

#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "programs.h"

namespace lode::test {
namespace {

using Json = nlohmann::json;

class Loadtest : public testing::Test {
 protected:
  Json run(const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"loadtest", server_.url("small"), "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome outcome = lodestream(arguments);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return Json::parse(outcome.out);
  }

  WorkFolder folder_;
  RunningServer server_{{makeSmallStore(folder_)}};
};

TEST_F(Loadtest, answersEveryClientWithoutAnError) {
  for (const auto& decode : {std::vector<std::string>{}, {"--decode-off"}}) {
    std::vector<std::string> arguments{"--clients", "20", "--seconds", "2", "--threads", "2"};
    arguments.insert(arguments.end(), decode.begin(), decode.end());
    const Json told = run(arguments);
    EXPECT_EQ(told["clients"], 20);
    EXPECT_EQ(told["errors"], 0) << told["first_error"];
    EXPECT_EQ(told["first_image_ms"]["count"], 20);
    EXPECT_GT(told["blobs"], 40);
    EXPECT_GT(told["bytes"], told["blobs"]);
    EXPECT_GT(told["latency_ms"]["visible"]["count"], 0);
    EXPECT_LE(told["latency_ms"]["visible"]["p50"], told["latency_ms"]["visible"]["p99"]);
    EXPECT_LE(told["latency_ms"]["visible"]["p99"], told["latency_ms"]["visible"]["max"]);
  }
}

TEST_F(Loadtest, endsInTimeWithManyClients) {
  const Json told = run({"--clients", "300", "--seconds", "2", "--decode-off"});
  EXPECT_EQ(told["errors"], 0) << told["first_error"];
  EXPECT_EQ(told["first_image_ms"]["count"], 300);
}

TEST_F(Loadtest, thatNobodyAnswersFailsWithOneLine) {
  const std::string url = server_.url("nothing");
  expectFailure(lodestream({"loadtest", url, "--clients", "2", "--seconds", "1"}), {"nothing"});
}

}  // namespace
}  // namespace lode::test
