#include "client/loadtest/request_clock.h"

#include <vector>

#include <gtest/gtest.h>

namespace lode::app {
namespace {

using namespace std::chrono_literals;
using proto::RequestAction;
using proto::RequestClass;

constexpr core::TimePoint kThen{10s};

void say(RequestClock& clock, RequestAction action, uint32_t request, uint32_t blob,
         core::TimePoint now = kThen, RequestClock::Requests&& lost = {}) {
  clock.sent(proto::encode(proto::Requests{1, {{action, RequestClass::kMargin, request, blob, 2.5f}}}, 3),
             now, lost);
}

TEST(RequestClock, tellsWhenABlobsRequestWasSent) {
  RequestClock clock;
  say(clock, RequestAction::kAdd, 9, 20);
  const auto request = clock.arrived(20);
  ASSERT_TRUE(request);
  EXPECT_EQ(request->sent, kThen);
  EXPECT_EQ(request->request_class, RequestClass::kMargin);
  EXPECT_TRUE(clock.open().empty());
}

TEST(RequestClock, knowsNothingOfBlobsThatComeUnasked) { EXPECT_FALSE(RequestClock().arrived(20)); }

TEST(RequestClock, forgetsWhatIsTakenBack) {
  RequestClock clock;
  say(clock, RequestAction::kAdd, 9, 20);
  say(clock, RequestAction::kAdd, 10, 21);
  say(clock, RequestAction::kCancel, 9, 0);
  EXPECT_FALSE(clock.arrived(20));
  EXPECT_TRUE(clock.arrived(21));
}

TEST(RequestClock, countsARequestThatIsMadeAgainFromThen) {
  RequestClock clock;
  say(clock, RequestAction::kAdd, 9, 20);
  say(clock, RequestAction::kCancel, 9, 0);
  say(clock, RequestAction::kAdd, 10, 20, kThen + 1s);
  EXPECT_EQ(clock.open().size(), 1u);
  EXPECT_EQ(clock.arrived(20)->sent, kThen + 1s);
}

TEST(RequestClock, countsARequestThatWasLostElsewhereFromWhenItWasSentThere) {
  RequestClock::Requests lost{{20, {5, RequestClass::kVisible, kThen}},
                              {21, {6, RequestClass::kVisible, kThen}}};
  RequestClock clock;
  clock.sent(
      proto::encode(proto::Requests{1, {{RequestAction::kAdd, RequestClass::kMargin, 9, 20, 2.5f}}}, 3),
      kThen + 3s, lost);
  EXPECT_EQ(clock.arrived(20)->sent, kThen);
  EXPECT_EQ(lost.size(), 1u) << "the other may be made again later";
}

TEST(RequestClock, letsANewPriorityChangeNothing) {
  RequestClock clock;
  say(clock, RequestAction::kAdd, 9, 20);
  say(clock, RequestAction::kReprioritise, 9, 0, kThen + 1s);
  EXPECT_EQ(clock.arrived(20)->sent, kThen);
}

}  // namespace
}  // namespace lode::app
