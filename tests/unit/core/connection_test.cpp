#include "client/core/session/connection.h"

#include <set>

#include <gtest/gtest.h>

#include "tests/unit/core/session_fixture.h"

namespace lode::core {
namespace {

using std::chrono::milliseconds;
constexpr TimePoint kLinkStart{};

Connection makeConnection(uint32_t seed) {
  SessionOptions options;
  options.model = "model";
  return Connection(options, seed);
}

/// Returns the time until the next attempt is due.
milliseconds waitOf(const Connection& connection, TimePoint from) {
  milliseconds wait{0};
  while (!connection.due(from + wait)) ++wait;
  return wait;
}

TEST(Connection, isDueAtOnceButNotDuringASession) {
  Connection connection = makeConnection(1);
  EXPECT_TRUE(connection.due(kLinkStart));
  connection.begin({}, kLinkStart);
  EXPECT_FALSE(connection.due(kLinkStart));
  EXPECT_TRUE(connection.session());
}

TEST(Connection, waitsHalfAsLongAgainAfterEachFailureUpToALimit) {
  Connection connection = makeConnection(1);
  milliseconds longest = kFirstRetry;
  for (int failure = 0; failure < 20; ++failure) {
    connection.begin({}, kLinkStart);
    connection.end("gone", kLinkStart);
    const milliseconds wait = waitOf(connection, kLinkStart);
    EXPECT_GE(wait, longest / 2);
    EXPECT_LE(wait, longest);
    longest = std::min<milliseconds>(longest * 3 / 2, kLastRetry);
  }
  EXPECT_EQ(longest, kLastRetry);
  connection.begin({}, kLinkStart);
  connection.succeeded();
  connection.end("gone", kLinkStart);
  EXPECT_LE(waitOf(connection, kLinkStart), kFirstRetry);
}

TEST(Connection, reconnectsSoonAfterAShortOutage) {
  const std::chrono::seconds away(3);
  for (uint32_t seed = 0; seed < 1000; ++seed) {
    Connection connection = makeConnection(seed);
    TimePoint now = kLinkStart;
    while (now < kLinkStart + away) {
      connection.begin({}, now);
      connection.end("refused", now);
      now += waitOf(connection, now);
    }
    EXPECT_LE(now, kLinkStart + milliseconds(5550)) << seed;
  }
}

TEST(Connection, waitsDifferentTimesWithDifferentSeeds) {
  std::set<milliseconds> waits;
  for (uint32_t seed = 0; seed < 20; ++seed) {
    Connection connection = makeConnection(seed);
    connection.end("gone", kLinkStart);
    waits.insert(waitOf(connection, kLinkStart));
  }
  EXPECT_GT(waits.size(), 10u);
}

TEST(Connection, retriesOnlyANetworkErrorAfterTheModelWasOpen) {
  Connection connection = makeConnection(1);
  connection.begin({}, kLinkStart);
  EXPECT_THROW(connection.fail(Error(ErrorCode::kNetwork, "refused"), kLinkStart), Error);
  connection.succeeded();
  connection.fail(Error(ErrorCode::kNetwork, "reset", Remedy::kCertificate), kLinkStart);
  EXPECT_EQ(connection.trouble(), "reset");
  EXPECT_EQ(connection.troubleRemedy(), Remedy::kCertificate);
  EXPECT_THROW(connection.fail(Error(ErrorCode::kProtocol, "nonsense"), kLinkStart), Error);
}

TEST(Connection, retriesTheFirstOpenUntilItsPatienceEnds) {
  SessionOptions options;
  options.model = "model";
  options.open_patience = std::chrono::seconds(20);
  Connection connection(options, 1);
  TimePoint now = kLinkStart;
  while (now < kLinkStart + options.open_patience) {
    connection.begin({}, now);
    connection.fail(Error(ErrorCode::kNetwork, "refused"), now);
    now += waitOf(connection, now);
  }
  connection.begin({}, now);
  EXPECT_THROW(connection.fail(Error(ErrorCode::kNetwork, "refused"), now), Error);
}

TEST(Connection, doesNotRetryIfTheServerRefuses) {
  SessionOptions options;
  options.model = "model";
  options.open_patience = std::chrono::seconds(20);
  Connection connection(options, 1);
  connection.begin({}, kLinkStart);
  EXPECT_THROW(connection.fail(Error(ErrorCode::kInput, "no such model"), kLinkStart), Error);
}

TEST(Connection, movesOnEvenIfTheServerRepeatsGoAway) {
  Connection connection = makeConnection(1);
  connection.begin({}, kLinkStart);
  connection.session()->receive(fixture::welcome(), kLinkStart);
  connection.session()->receive(fixture::opened(), kLinkStart);
  while (connection.session()->nextEvent()) {
  }
  TimePoint now = kLinkStart;
  for (; now < kLinkStart + kMoveOn; now += milliseconds(1)) connection.leave("maintenance", now);
  EXPECT_TRUE(connection.due(now));
}

TEST(Connection, pausesBetweenRestartsOfAModelThatIsReplacedAllTheTime) {
  Connection connection = makeConnection(1);
  TimePoint now = kLinkStart;
  size_t restarts = 0;
  for (; now < kLinkStart + std::chrono::seconds(10); now += milliseconds(1)) {
    if (!connection.due(now)) continue;
    connection.begin({}, now);
    connection.succeeded();
    connection.restart(now);
    ++restarts;
  }
  EXPECT_LE(restarts, 25u);
}

TEST(Connection, saysNothingOfTroubleOnceItWorksAgain) {
  Connection connection = makeConnection(1);
  connection.begin({}, kLinkStart);
  connection.end("gone", kLinkStart);
  EXPECT_EQ(connection.trouble(), "gone");
  connection.begin({}, kLinkStart + kLastRetry);
  connection.succeeded();
  EXPECT_EQ(connection.trouble(), "");
}

TEST(Connection, countsTheBytesOfAllSessionsIncludingADrainingOne) {
  Connection connection = makeConnection(1);
  const proto::Bytes bytes = fixture::welcome();
  for (uint64_t sessions = 1; sessions <= 3; ++sessions) {
    connection.begin({}, kLinkStart);
    connection.session()->receive(bytes, kLinkStart);
    EXPECT_EQ(connection.receivedBytes(), sessions * bytes.size());
  }
  connection.endDraining();
  EXPECT_EQ(connection.receivedBytes(), 3 * bytes.size());
}

}  // namespace
}  // namespace lode::core
