#include "server/serve/net/byte_rate.h"

#include <algorithm>
#include <array>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/serve/server_fixture.h"

namespace lode::serve {
namespace {

using namespace std::chrono_literals;
using Clock = ByteRate::Clock;

constexpr Clock::time_point kFirstTake{1000s};

TEST(ByteRate, delaysNobodyIfUnlimited) {
  ByteRate rate(0);
  EXPECT_FALSE(rate.limited());
  for (int i = 0; i < 100; ++i) EXPECT_EQ(rate.take(1u << 30, kFirstTake), kFirstTake);
}

TEST(ByteRate, givesTurnsInOrderAsFarApartAsTheirBytesLast) {
  ByteRate rate(1'000'000);
  const auto first = rate.take(10'000, kFirstTake);
  EXPECT_LE(first, kFirstTake);
  EXPECT_EQ(rate.take(20'000, kFirstTake) - first, 10ms);
  EXPECT_EQ(rate.take(10'000, kFirstTake) - first, 30ms);
}

TEST(ByteRate, passesReturnedBytesToTheNextTurn) {
  ByteRate rate(1'000'000);
  const auto first = rate.take(10'000, kFirstTake);
  rate.give(4'000);
  EXPECT_EQ(rate.take(10'000, kFirstTake) - first, 6ms);
}

TEST(ByteRate, holdsForLateTurnsAndSavesUpNothing) {
  ByteRate rate(1'000'000);
  Clock::time_point now = kFirstTake;
  uint64_t bytes = 0;
  for (; now < kFirstTake + 10s; bytes += 10'000)
    now = std::max(now, rate.take(10'000, now)) + 1ms;  // calls take() late each time
  EXPECT_NEAR(static_cast<double>(bytes), 10e6, 0.1e6);
  now += 60s;  // a minute of silence
  const auto first = rate.take(1'000'000, now);
  EXPECT_GE(first, now - ByteRate::kGrace);
  EXPECT_GE(rate.take(1, now), now + 1s - ByteRate::kGrace);
}

class ServerRates : public test::ServerTest {
 protected:
  /// Measures how long new clients take to open "a" and receive its blobs of 9 KB, then its blobs of 480 KB.
  std::array<double, 3> secondsOfThreeAtOnce() {
    reader();  // opened here because all threads read it
    std::array<double, 3> seconds{};
    std::vector<std::jthread> clients;
    for (double& each : seconds)
      clients.emplace_back([this, &each] {
        const auto before = Clock::now();
        expectServed();
        each = std::chrono::duration<double>(Clock::now() - before).count();
      });
    clients.clear();
    return seconds;
  }
};

TEST_F(ServerRates, aConnectionGetsNoMoreThanItsRateAndEachHasItsOwn) {
  options_.bytes_per_second_per_connection = 2'000'000;
  start();
  for (const double each : secondsOfThreeAtOnce()) {
    EXPECT_GT(each, 0.48 / 2 - 0.03);
    EXPECT_LT(each, 3 * 0.48 / 2) << "as if all had one rate";
  }
}

TEST_F(ServerRates, allTogetherGetNoMoreThanTheRateAndEachHasAShare) {
  options_.bytes_per_second = 4'000'000;
  start();
  const auto seconds = secondsOfThreeAtOnce();
  EXPECT_GT(*std::ranges::max_element(seconds), 3 * 0.48 / 4 - 0.03);
  EXPECT_GT(*std::ranges::min_element(seconds), 0.5 * *std::ranges::max_element(seconds));
}

TEST_F(ServerRates, delayOnlyBlobs) {
  options_.bytes_per_second_per_connection = 10'000;
  start();
  test::TestClient client = connect();
  client.open("a");  // the client's first blobs take 16 seconds
  client.send(proto::Ping{7});
  const auto before = Clock::now();
  while (true) {
    const auto frame = client.receive();
    ASSERT_TRUE(frame);
    if (frame->is(proto::FrameType::kPong)) break;
  }
  EXPECT_LT(Clock::now() - before, 1s);
}

}  // namespace
}  // namespace lode::serve
