#include "client/app/cli/build_step.h"

#include <gtest/gtest.h>

namespace lode::app {
namespace {

using namespace std::chrono_literals;

TEST(BuildStep, isDescribedWithTheTimeLeft) {
  EXPECT_EQ(stepInWords({"simplifying", 0.46, 12.4}), "simplifying; 12 s left");
  EXPECT_EQ(stepInWords({"simplifying", 0.46, 150}), "simplifying; 3 min left");
  EXPECT_EQ(stepInWords({"simplifying", 0.46, 7200}), "simplifying; 2 h left");
  EXPECT_EQ(stepInWords({"reading the file", 0, {}}), "reading the file");
}

TEST(BuildStep, isCompleteOnlyAtTheEnd) {
  EXPECT_EQ(percentInWords(0.999), "99 %");
  EXPECT_EQ(percentInWords(1), "100 %");
  EXPECT_EQ(percentInWords(-1), "0 %");
}

TEST(BuildLog, hasALineEveryFiveSeconds) {
  const BuildLog::TimePoint begin{1h};
  BuildLog log(begin);
  int lines = 0;
  for (auto time = 0ms; time <= 60s; time += 100ms) {
    const auto line = log.add({"simplifying", 0.5, 12}, begin + time);
    if (!line) continue;
    ++lines;
    EXPECT_EQ(*line, "50 %, simplifying; 12 s left");
    EXPECT_EQ(time % 5s, 0ms);
  }
  EXPECT_EQ(lines, 12);
}

TEST(BuildLog, isEmptyOfAShortBuild) {
  const BuildLog::TimePoint begin{1h};
  BuildLog log(begin);
  EXPECT_FALSE(log.add({"simplifying", 0.9, 1}, begin + 4900ms));
}

}  // namespace
}  // namespace lode::app
