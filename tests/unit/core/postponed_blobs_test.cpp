#include "client/core/cache/postponed_blobs.h"

#include <gtest/gtest.h>

namespace lode::core {
namespace {

constexpr TimePoint kBegin{};

TEST(PostponedBlobs, areReleasedTogetherWhenThePauseOfTheFirstIsOver) {
  PostponedBlobs postponed;
  postponed.add(1, "first", kBegin);
  postponed.add(2, "second", kBegin + kFirstRepeat / 2);
  EXPECT_TRUE(postponed.contains(1) && postponed.contains(2));
  EXPECT_FALSE(postponed.release(kBegin + kFirstRepeat - std::chrono::milliseconds(1)));
  EXPECT_TRUE(postponed.release(kBegin + kFirstRepeat));
  EXPECT_FALSE(postponed.contains(1) || postponed.contains(2));
  EXPECT_EQ(postponed.why(), "first");
}

TEST(PostponedBlobs, pauseLongerAfterEachRefusalAndShortAgainAfterAllHaveArrived) {
  PostponedBlobs postponed;
  TimePoint now = kBegin;
  const auto pauseOf = [&](uint32_t blob) {
    postponed.add(blob, "no", now);
    const TimePoint begin = now;
    while (!postponed.release(now)) now += std::chrono::milliseconds(100);
    return now - begin;
  };
  auto last = pauseOf(1);
  EXPECT_EQ(last, kFirstRepeat);
  for (int time = 0; time < 20; ++time) {
    const auto next = pauseOf(1);
    EXPECT_TRUE(next > last || next == kLastRepeat);
    last = next;
  }
  EXPECT_EQ(last, kLastRepeat);
  postponed.arrived(1);
  EXPECT_EQ(postponed.why(), "");
  EXPECT_EQ(pauseOf(2), kFirstRepeat);
}

TEST(PostponedBlobs, keepTheirReasonUntilTheLastHasArrived) {
  PostponedBlobs postponed;
  postponed.add(1, "no", kBegin);
  postponed.add(2, "no", kBegin);
  postponed.release(kBegin + kFirstRepeat);
  postponed.arrived(1);
  EXPECT_EQ(postponed.why(), "no");
  postponed.arrived(2);
  EXPECT_EQ(postponed.why(), "");
}

TEST(PostponedBlobs, areForgottenAboveTheLimit) {
  PostponedBlobs postponed;
  for (uint32_t blob = 1; blob <= kMaxPostponedBlobs; ++blob) postponed.add(blob, "no", kBegin);
  EXPECT_TRUE(postponed.contains(1));
  postponed.add(kMaxPostponedBlobs + 1, "no", kBegin);
  EXPECT_FALSE(postponed.contains(1));
  EXPECT_TRUE(postponed.contains(kMaxPostponedBlobs + 1));
}

TEST(PostponedBlobs, areForgottenIfNotRequestedAgain) {
  PostponedBlobs postponed;
  postponed.add(1, "no", kBegin);
  EXPECT_TRUE(postponed.release(kBegin + kFirstRepeat));
  EXPECT_FALSE(postponed.release(kBegin + 2 * kLastRepeat));
  EXPECT_EQ(postponed.why(), "");
}

}  // namespace
}  // namespace lode::core
