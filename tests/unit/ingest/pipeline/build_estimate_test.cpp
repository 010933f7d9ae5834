#include "server/ingest/pipeline/build_estimate.h"

#include <vector>

#include <gtest/gtest.h>

namespace lode::ingest {
namespace {

struct StageTime {
  const char* name;
  double seconds;
};

/// Stage times measured on one thread of a busy machine, with 2 million triangles.
const std::vector<StageTime> kUsual{{"scan", 0.36},      {"dereference", 0.5}, {"sort", 0.34},
                                    {"partition", 0.63}, {"simplify", 13.83},  {"pack", 0.05}};
constexpr uint64_t kModelTriangles = 2'000'000;

/// Reports the stages in steps of a percent. @param check  called with the time after each report.
template <class Check>
void runStages(BuildEstimate& estimate, const std::vector<StageTime>& stages, Check check) {
  double seconds = 0;
  for (const StageTime& stage : stages) {
    for (uint64_t percent = 1; percent <= 100; ++percent) {
      seconds += stage.seconds / 100;
      estimate.update(stage.name, static_cast<double>(percent) / 100, kModelTriangles * percent / 100,
                      kModelTriangles, seconds);
      check(seconds);
    }
  }
}

double totalOf(const std::vector<StageTime>& stages) {
  double seconds = 0;
  for (const StageTime& stage : stages) seconds += stage.seconds;
  return seconds;
}

TEST(BuildEstimate, isTheShareOfTheWholeTime) {
  BuildEstimate estimate(1);
  const double total_s = totalOf(kUsual);
  runStages(estimate, kUsual, [&](double seconds) {
    const BuildStatus status = estimate.status();
    EXPECT_NEAR(status.fraction, seconds / total_s, 0.08);
    ASSERT_TRUE(status.seconds_left);
    if (seconds < 4) return;
    EXPECT_NEAR(*status.seconds_left, total_s - seconds, 0.3 * total_s);
  });
  EXPECT_EQ(estimate.status().fraction, 1);
  EXPECT_EQ(estimate.status().seconds_left, 0);
}

TEST(BuildEstimate, neverFallsEvenIfStagesTakeUnusualTimes) {
  for (const double factor : {0.1, 10.0}) {
    for (size_t unusual = 0; unusual < kUsual.size(); ++unusual) {
      std::vector<StageTime> stages = kUsual;
      stages[unusual].seconds *= factor;
      BuildEstimate estimate(1);
      double last = 0;
      runStages(estimate, stages, [&](double) {
        EXPECT_GE(estimate.status().fraction, last);
        last = estimate.status().fraction;
        EXPECT_LE(last, 1);
      });
      EXPECT_EQ(last, 1) << stages[unusual].name << " " << factor;
    }
  }
}

TEST(BuildEstimate, isCorrectedByFinishedStages) {
  std::vector<StageTime> slow = kUsual;
  slow.front().seconds *= 8;  // as for an ascii file
  for (StageTime& stage : slow) stage.seconds *= 3;
  BuildEstimate estimate(1);
  const double total_s = totalOf(slow);
  runStages(estimate, slow, [&](double seconds) {
    if (seconds < 0.4 * total_s) return;
    EXPECT_NEAR(*estimate.status().seconds_left, total_s - seconds, 0.2 * total_s);
  });
}

TEST(BuildEstimate, countsTheLoadedWorkOfAResumedBuild) {
  BuildEstimate estimate(1);
  estimate.update("simplify", 0.5, 100, 200, 0.1);
  estimate.update("simplify", 0.51, 102, 200, 1.1);
  EXPECT_NEAR(estimate.status().fraction, 0.5, 0.1);
  EXPECT_NEAR(*estimate.status().seconds_left, 50, 10);
  EXPECT_EQ(estimate.status().items_per_s, 0) << "the number of triangles is unknown";
}

TEST(BuildEstimate, expectsLessOfSimplifyWithMoreThreads) {
  BuildEstimate one(1), eight(8);
  one.update("scan", 1, 1, 1, 1);
  eight.update("scan", 1, 1, 1, 1);
  EXPECT_LT(one.status().fraction, 0.03);
  EXPECT_GT(eight.status().fraction, 0.08);
}

TEST(BuildEstimate, saysWhatIsDoneInWordsAndTriangles) {
  BuildEstimate estimate(1);
  EXPECT_TRUE(estimate.status().doing.empty());
  estimate.update("partition", 1, kModelTriangles, kModelTriangles, 1);
  estimate.update("simplify", 0.25, 50, 200, 3);
  const BuildStatus status = estimate.status();
  EXPECT_EQ(status.doing, "simplifying");
  EXPECT_EQ(status.done, kModelTriangles / 4);
  EXPECT_EQ(status.total, kModelTriangles);
  EXPECT_EQ(status.unit, "triangles");
  EXPECT_DOUBLE_EQ(status.items_per_s, kModelTriangles / 8.0);
}

TEST(BuildEstimate, ignoresUnknownStages) {
  BuildEstimate estimate(1);
  estimate.update("polish", 0.5, 1, 2, 1);
  EXPECT_TRUE(estimate.status().doing.empty());
  EXPECT_EQ(estimate.status().fraction, 0);
}

}  // namespace
}  // namespace lode::ingest
