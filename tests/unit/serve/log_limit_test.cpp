#include "server/serve/ops/log_limit.h"

#include <gtest/gtest.h>

namespace lode::serve {
namespace {

using namespace std::chrono_literals;

const LogLimit::TimePoint kFirstLine{1000s};

/// @return how many of `lines` were admitted.
int admitted(LogLimit& limit, LogKind kind, int lines, LogLimit::TimePoint now) {
  int count = 0;
  for (int i = 0; i < lines; ++i) count += limit.admit(kind, now);
  return count;
}

TEST(LogLimit, letsABurstThroughAndThenSoManyASecond) {
  LogLimit limit;
  EXPECT_EQ(admitted(limit, LogKind::kDamagedStore, 10'000, kFirstLine), 50);
  EXPECT_EQ(admitted(limit, LogKind::kDamagedStore, 10'000, kFirstLine + 1s), 5);
  EXPECT_EQ(admitted(limit, LogKind::kDamagedStore, 10'000, kFirstLine + 1s), 0);
  EXPECT_EQ(admitted(limit, LogKind::kDamagedStore, 10'000, kFirstLine + 1h), 50);
}

TEST(LogLimit, ofOneKindDoesNotTouchAnother) {
  LogLimit limit;
  admitted(limit, LogKind::kDamagedStore, 10'000, kFirstLine);
  EXPECT_TRUE(limit.admit(LogKind::kRefused, kFirstLine));
}

TEST(LogLimit, tellsOnceHowManyWereLeftOutWhenThereIsRoomAgain) {
  LogLimit limit;
  admitted(limit, LogKind::kRefused, 60, kFirstLine);
  EXPECT_EQ(limit.takeLeftOut(LogKind::kRefused, kFirstLine), 0u);
  EXPECT_EQ(limit.takeLeftOut(LogKind::kRefused, kFirstLine + 1s), 10u);
  EXPECT_EQ(limit.takeLeftOut(LogKind::kRefused, kFirstLine + 2s), 0u);
  EXPECT_EQ(limit.takeLeftOut(LogKind::kDamagedStore, kFirstLine + 2s), 0u);
}

TEST(LogLimit, bearsAClockThatStandsOrGoesBack) {
  LogLimit limit;
  EXPECT_EQ(admitted(limit, LogKind::kSystem, 100, kFirstLine), 50);
  EXPECT_EQ(admitted(limit, LogKind::kSystem, 100, kFirstLine - 10s), 0);
  EXPECT_EQ(admitted(limit, LogKind::kSystem, 100, kFirstLine + 1s), 5);
}

}  // namespace
}  // namespace lode::serve
