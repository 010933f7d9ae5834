#include "client/app/cli/remedy_words.h"

#include <set>
#include <string>

#include <gtest/gtest.h>

#include "client/app/cli/stream_report.h"
#include "client/loadtest/load_counts.h"

namespace lode::app {
namespace {

TEST(RemedyWords, areThereForEachRemedyAndDifferent) {
  EXPECT_STREQ(wordsFor(Remedy::kNone), "");
  std::set<std::string> all;
  for (int code = 1; code <= static_cast<int>(kLastRemedy); ++code) {
    const std::string words = wordsFor(static_cast<Remedy>(code));
    EXPECT_NE(words, "") << code;
    EXPECT_TRUE(all.insert(words).second) << words;
  }
}

TEST(RemedyWords, endTheMessageOfAnError) {
  EXPECT_EQ(messageOf(Error(ErrorCode::kInput, "it is closed; try again")), "it is closed; try again");
  EXPECT_EQ(messageOf(Error(ErrorCode::kInput, "it requires a token", Remedy::kToken)),
            "it requires a token; give a token with --token-file or LODESTREAM_TOKEN");
}

TEST(RemedyWords, endTheFailuresInReports) {
  stream::StreamStatus status;
  status.failure = "no model 'a'";
  status.failure_remedy = Remedy::kModel;
  nlohmann::ordered_json json;
  reportGaps(json, status);
  EXPECT_EQ(json["failure"], "no model 'a'; lodestream list shows what it has");
  LoadCounts counts;
  counts.noteError(Error(ErrorCode::kInput, status.failure, status.failure_remedy));
  EXPECT_EQ(counts.first_error, json["failure"].get<std::string>());
}

TEST(RemedyWords, endTheReasonWhyAViewDidNotConverge) {
  CommonOptions options;
  options.target = "lode://host/a";
  const auto refusal = [&](const stream::StreamStatus& status) {
    try {
      refuseUnconverged("key 2", status, options);
    } catch (const Error& error) {
      return messageOf(error);
    }
  };
  stream::StreamStatus status;
  status.trouble = "no model 'a'";
  status.trouble_remedy = Remedy::kModel;
  const std::string words = ": no model 'a'; lodestream list shows what it has";
  EXPECT_EQ(refusal(status), "lode://host/a did not converge at key 2 within 120000 ms" + words);
  status.failure = status.trouble;
  status.failure_remedy = status.trouble_remedy;
  EXPECT_EQ(refusal(status), "lode://host/a did not converge at key 2" + words);
}

}  // namespace
}  // namespace lode::app
