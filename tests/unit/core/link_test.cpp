#include "client/core/link.h"

#include <set>

#include <gtest/gtest.h>

namespace lode::core {
namespace {

using std::chrono::milliseconds;

constexpr TimePoint kStart{};

Link makeLink(uint32_t seed) {
  SessionOptions options;
  options.model = "model";
  return Link(options, seed);
}

/// The time until the next try is due.
milliseconds waitOf(const Link& link, TimePoint from) {
  milliseconds wait{0};
  while (!link.due(from + wait)) ++wait;
  return wait;
}

TEST(Link, isDueAtOnceAndNotWhileThereIsASession) {
  Link link = makeLink(1);
  EXPECT_TRUE(link.due(kStart));
  link.begin({}, kStart);
  EXPECT_FALSE(link.due(kStart));
  EXPECT_TRUE(link.session());
}

TEST(Link, waitsTwiceAsLongAfterEachFailureUpToALimit) {
  Link link = makeLink(1);
  milliseconds longest = kFirstRetry;
  for (int failure = 0; failure < 12; ++failure) {
    link.begin({}, kStart);
    link.end("gone", kStart);
    const milliseconds wait = waitOf(link, kStart);
    EXPECT_GE(wait, longest / 2);
    EXPECT_LE(wait, longest);
    longest = std::min<milliseconds>(2 * longest, kLastRetry);
  }
  link.begin({}, kStart);
  link.succeeded();
  link.end("gone", kStart);
  EXPECT_LE(waitOf(link, kStart), kFirstRetry);
}

TEST(Link, waitsOtherTimesWithOtherSeeds) {
  std::set<milliseconds> waits;
  for (uint32_t seed = 0; seed < 20; ++seed) {
    Link link = makeLink(seed);
    link.end("gone", kStart);
    waits.insert(waitOf(link, kStart));
  }
  EXPECT_GT(waits.size(), 10u);
}

TEST(Link, triesAnewOnlyWhereTheModelWasOpenAndTheNetworkIsToBlame) {
  Link link = makeLink(1);
  link.begin({}, kStart);
  EXPECT_THROW(link.fail(Error(ErrorCode::kNetwork, "refused"), kStart), Error);
  link.succeeded();
  link.fail(Error(ErrorCode::kNetwork, "reset"), kStart);
  EXPECT_EQ(link.trouble(), "reset");
  EXPECT_THROW(link.fail(Error(ErrorCode::kProtocol, "nonsense"), kStart), Error);
}

TEST(Link, saysNothingOfTroubleOnceItWorksAgain) {
  Link link = makeLink(1);
  link.begin({}, kStart);
  link.end("gone", kStart);
  EXPECT_EQ(link.trouble(), "gone");
  link.begin({}, kStart + kLastRetry);
  link.succeeded();
  EXPECT_EQ(link.trouble(), "");
}

}  // namespace
}  // namespace lode::core
