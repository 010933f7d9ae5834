#include "client/loadtest/latency_histogram.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace lode::app {
namespace {

using namespace std::chrono_literals;

TEST(LatencyHistogram, isZeroWithoutADuration) {
  const LatencyHistogram histogram;
  EXPECT_EQ(histogram.count(), 0u);
  EXPECT_EQ(histogram.percentileMs(0.99), 0);
  EXPECT_EQ(histogram.maxMs(), 0);
}

TEST(LatencyHistogram, knowsEveryPercentileToAThirtySecond) {
  std::mt19937_64 random(7);
  LatencyHistogram histogram;
  std::vector<double> all_ms;
  for (int i = 0; i < 20'000; ++i) {
    const uint64_t us = random() >> (random() % 40 + 24);  // 1 to 40 bits
    histogram.add(std::chrono::microseconds(us));
    all_ms.push_back(static_cast<double>(std::min<uint64_t>(us, 0xFFFFFFFF)) * 1e-3);
  }
  std::ranges::sort(all_ms);
  for (const double part : {0.01, 0.25, 0.5, 0.9, 0.99, 0.999, 1.0}) {
    const double exact = all_ms[static_cast<size_t>(std::ceil(part * 20'000)) - 1];
    EXPECT_GE(histogram.percentileMs(part), exact) << part;
    EXPECT_LE(histogram.percentileMs(part), exact * (1 + 1.0 / 32)) << part;
  }
  EXPECT_EQ(histogram.maxMs(), all_ms.back());
}

TEST(LatencyHistogram, clampsDurationsToItsRange) {
  LatencyHistogram histogram;
  histogram.add(-5ms);
  EXPECT_EQ(histogram.maxMs(), 0);
  histogram.add(24h * 365);
  EXPECT_EQ(histogram.count(), 2u);
  EXPECT_NEAR(histogram.maxMs(), 4294967.295, 1e-3);
}

TEST(LatencyHistogram, addsUpHistograms) {
  LatencyHistogram one, other;
  one.add(1ms);
  other.add(3ms);
  other.add(9ms);
  one.add(other);
  EXPECT_EQ(one.count(), 3u);
  EXPECT_NEAR(one.percentileMs(0.5), 3, 0.1);
  EXPECT_EQ(one.maxMs(), 9);
}

TEST(LatencyHistogram, givesTheDurationsSinceAnEarlierState) {
  LatencyHistogram histogram;
  for (int i = 0; i < 9; ++i) histogram.add(100ms);
  const LatencyHistogram earlier = histogram;
  histogram.add(3ms);
  EXPECT_EQ(histogram.since(earlier).count(), 1u);
  EXPECT_NEAR(histogram.since(earlier).percentileMs(0.99), 3, 0.1);
}

}  // namespace
}  // namespace lode::app
