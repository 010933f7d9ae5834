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

TEST(BuildStep, isDescribedWithItsItemsAndTheirRate) {
  EXPECT_EQ(stepInWords({"simplifying", 0.6, 12, 1.2e6, 2e6, 3e5, "triangles"}),
            "simplifying: 1.2 of 2.0 million triangles, 0.3 million a second; 12 s left");
  EXPECT_EQ(stepInWords({"simplifying", 0.1, {}, 1.2e6, 2e6, 5.6e4, "triangles"}),
            "simplifying: 1.2 of 2.0 million triangles, 56 thousand a second");
  EXPECT_EQ(stepInWords({"making triangles", 0.1, {}, 120e3, 350e3, 0, "faces"}),
            "making triangles: 120 of 350 thousand faces");
  EXPECT_EQ(stepInWords({"preparing images", 0.1, {}, 3, 40, 2, "tiles"}),
            "preparing images: 3 of 40 tiles, 2 a second");
  EXPECT_EQ(stepInWords({"reading the file", 0.1, {}, 1.2e9, 2e9, 3e8, "B"}),
            "reading the file: 1.2 GB of 2.0 GB, 300.0 MB a second");
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
