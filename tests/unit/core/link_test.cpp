#include "client/core/link.h"

#include <set>

#include <gtest/gtest.h>

#include "tests/unit/core/session_fixture.h"

namespace lode::core {
namespace {

using std::chrono::milliseconds;
constexpr TimePoint kLinkStart{};

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
  EXPECT_TRUE(link.due(kLinkStart));
  link.begin({}, kLinkStart);
  EXPECT_FALSE(link.due(kLinkStart));
  EXPECT_TRUE(link.session());
}

TEST(Link, waitsHalfAsLongAgainAfterEachFailureUpToALimit) {
  Link link = makeLink(1);
  milliseconds longest = kFirstRetry;
  for (int failure = 0; failure < 20; ++failure) {
    link.begin({}, kLinkStart);
    link.end("gone", kLinkStart);
    const milliseconds wait = waitOf(link, kLinkStart);
    EXPECT_GE(wait, longest / 2);
    EXPECT_LE(wait, longest);
    longest = std::min<milliseconds>(longest * 3 / 2, kLastRetry);
  }
  EXPECT_EQ(longest, kLastRetry);
  link.begin({}, kLinkStart);
  link.succeeded();
  link.end("gone", kLinkStart);
  EXPECT_LE(waitOf(link, kLinkStart), kFirstRetry);
}

TEST(Link, isBackSoonAfterAServerThatWasNotAwayForLong) {
  const std::chrono::seconds away(3);
  for (uint32_t seed = 0; seed < 1000; ++seed) {
    Link link = makeLink(seed);
    TimePoint now = kLinkStart;
    while (now < kLinkStart + away) {
      link.begin({}, now);
      link.end("refused", now);
      now += waitOf(link, now);
    }
    EXPECT_LE(now, kLinkStart + milliseconds(5550)) << seed;
  }
}

TEST(Link, waitsOtherTimesWithOtherSeeds) {
  std::set<milliseconds> waits;
  for (uint32_t seed = 0; seed < 20; ++seed) {
    Link link = makeLink(seed);
    link.end("gone", kLinkStart);
    waits.insert(waitOf(link, kLinkStart));
  }
  EXPECT_GT(waits.size(), 10u);
}

TEST(Link, triesAnewOnlyWhereTheModelWasOpenAndTheNetworkIsToBlame) {
  Link link = makeLink(1);
  link.begin({}, kLinkStart);
  EXPECT_THROW(link.fail(Error(ErrorCode::kNetwork, "refused"), kLinkStart), Error);
  link.succeeded();
  link.fail(Error(ErrorCode::kNetwork, "reset"), kLinkStart);
  EXPECT_EQ(link.trouble(), "reset");
  EXPECT_THROW(link.fail(Error(ErrorCode::kProtocol, "nonsense"), kLinkStart), Error);
}

TEST(Link, saysNothingOfTroubleOnceItWorksAgain) {
  Link link = makeLink(1);
  link.begin({}, kLinkStart);
  link.end("gone", kLinkStart);
  EXPECT_EQ(link.trouble(), "gone");
  link.begin({}, kLinkStart + kLastRetry);
  link.succeeded();
  EXPECT_EQ(link.trouble(), "");
}

TEST(Link, countsWhatAllSessionsReceivedAlsoTheOneThatIsLeaving) {
  Link link = makeLink(1);
  const proto::Bytes bytes = fixture::welcome();
  for (uint64_t sessions = 1; sessions <= 3; ++sessions) {
    link.begin({}, kLinkStart);
    link.session()->receive(bytes, kLinkStart);
    EXPECT_EQ(link.receivedBytes(), sessions * bytes.size());
  }
  link.endLeaving();
  EXPECT_EQ(link.receivedBytes(), 3 * bytes.size());
}

}  // namespace
}  // namespace lode::core
