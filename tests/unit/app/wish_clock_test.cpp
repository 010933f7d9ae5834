#include "client/app/cli/wish_clock.h"

#include <vector>

#include <gtest/gtest.h>

namespace lode::app {
namespace {

using namespace std::chrono_literals;
using proto::WishAction;
using proto::WishClass;

constexpr core::TimePoint kThen{10s};

void say(WishClock& clock, WishAction action, uint32_t wish, uint32_t blob, core::TimePoint now = kThen,
         WishClock::Wishes&& lost = {}) {
  clock.sent(proto::encode(proto::Wishes{1, {{action, WishClass::kMargin, wish, blob, 2.5f}}}, 3), now, lost);
}

TEST(WishClock, tellsWhenABlobsWishWasSent) {
  WishClock clock;
  say(clock, WishAction::kAdd, 9, 20);
  const auto wish = clock.arrived(20);
  ASSERT_TRUE(wish);
  EXPECT_EQ(wish->sent, kThen);
  EXPECT_EQ(wish->wish_class, WishClass::kMargin);
  EXPECT_TRUE(clock.open().empty());
}

TEST(WishClock, knowsNothingOfBlobsThatComeUnasked) { EXPECT_FALSE(WishClock().arrived(20)); }

TEST(WishClock, forgetsWhatIsTakenBack) {
  WishClock clock;
  say(clock, WishAction::kAdd, 9, 20);
  say(clock, WishAction::kAdd, 10, 21);
  say(clock, WishAction::kCancel, 9, 0);
  EXPECT_FALSE(clock.arrived(20));
  EXPECT_TRUE(clock.arrived(21));
}

TEST(WishClock, countsAWishThatIsMadeAgainFromThen) {
  WishClock clock;
  say(clock, WishAction::kAdd, 9, 20);
  say(clock, WishAction::kCancel, 9, 0);
  say(clock, WishAction::kAdd, 10, 20, kThen + 1s);
  EXPECT_EQ(clock.open().size(), 1u);
  EXPECT_EQ(clock.arrived(20)->sent, kThen + 1s);
}

TEST(WishClock, countsAWishThatWasLostElsewhereFromWhenItWasSentThere) {
  WishClock::Wishes lost{{20, {5, WishClass::kVisible, kThen}}, {21, {6, WishClass::kVisible, kThen}}};
  WishClock clock;
  clock.sent(proto::encode(proto::Wishes{1, {{WishAction::kAdd, WishClass::kMargin, 9, 20, 2.5f}}}, 3),
             kThen + 3s, lost);
  EXPECT_EQ(clock.arrived(20)->sent, kThen);
  EXPECT_EQ(lost.size(), 1u) << "the other may be made again later";
}

TEST(WishClock, letsANewPriorityChangeNothing) {
  WishClock clock;
  say(clock, WishAction::kAdd, 9, 20);
  say(clock, WishAction::kReprioritise, 9, 0, kThen + 1s);
  EXPECT_EQ(clock.arrived(20)->sent, kThen);
}

}  // namespace
}  // namespace lode::app
