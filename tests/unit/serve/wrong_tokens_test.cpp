#include "server/serve/net/wrong_tokens.h"

#include <vector>

#include <gtest/gtest.h>

namespace lode::serve {
namespace {

using namespace std::chrono_literals;

class WrongTokensTest : public testing::Test {
 protected:
  WrongTokens tokens_{50ms};
  WrongTokens::Clock::time_point now_{};
};

TEST_F(WrongTokensTest, delayTheAnswersOfAnAddressTwiceAsLongEachTime) {
  for (const auto delay : {50ms, 100ms, 200ms, 400ms, 800ms, 1600ms, 3200ms, 5000ms, 5000ms}) {
    const auto wait = tokens_.add(1, now_);
    ASSERT_TRUE(wait);
    EXPECT_EQ(wait->until() - now_, delay);
  }
}

TEST_F(WrongTokensTest, delayOnlyTheirOwnAddress) {
  for (int i = 0; i < 20; ++i) tokens_.add(1, now_);
  EXPECT_EQ(tokens_.add(2, now_)->until() - now_, 50ms);
}

TEST_F(WrongTokensTest, areForgottenAfterAPause) {
  for (int i = 0; i < 20; ++i) tokens_.add(1, now_);
  now_ += WrongTokens::kForget;
  EXPECT_EQ(tokens_.add(1, now_)->until() - now_, WrongTokens::kLongestDelay);
  now_ += WrongTokens::kForget + 1ms;
  EXPECT_EQ(tokens_.add(1, now_)->until() - now_, 50ms);
}

TEST_F(WrongTokensTest, areLimitedInWaitingPerAddress) {
  std::vector<WrongTokens::Wait> waits;
  for (uint32_t i = 0; i < WrongTokens::kMostWaitingPerAddress; ++i) {
    EXPECT_FALSE(tokens_.blocks(1, now_));
    waits.push_back(*tokens_.add(1, now_));
  }
  EXPECT_TRUE(tokens_.blocks(1, now_));
  EXPECT_FALSE(tokens_.blocks(2, now_));
  EXPECT_FALSE(tokens_.add(1, now_));
  waits.pop_back();
  EXPECT_FALSE(tokens_.blocks(1, now_));
}

TEST_F(WrongTokensTest, areLimitedInWaitingForAllAddresses) {
  std::vector<WrongTokens::Wait> waits;
  for (uint64_t address = 0; address < WrongTokens::kMostWaiting; ++address)
    waits.push_back(*tokens_.add(address, now_));
  EXPECT_FALSE(tokens_.blocks(1000, now_)) << "an address without a wrong token is heard";
  EXPECT_FALSE(tokens_.add(1000, now_));
  EXPECT_TRUE(tokens_.blocks(1000, now_ + 49ms)) << "it has its delay without a place to wait";
  EXPECT_FALSE(tokens_.blocks(1000, now_ + 50ms));
  EXPECT_EQ(tokens_.waiting(), WrongTokens::kMostWaiting);
  waits.clear();
  EXPECT_EQ(tokens_.waiting(), 0u);
}

TEST_F(WrongTokensTest, forgetTheOldestAddressesAboveTheLimit) {
  const auto waits = tokens_.add(0, now_);
  for (uint64_t address = 1; address < 5 * WrongTokens::kMostAddresses; ++address)
    tokens_.add(address, now_ += 1ms);
  EXPECT_EQ(tokens_.addresses(), WrongTokens::kMostAddresses);
  EXPECT_EQ(tokens_.add(0, now_)->until() - now_, 100ms) << "an address that waits is kept";
  EXPECT_EQ(tokens_.add(5 * WrongTokens::kMostAddresses - 1, now_)->until() - now_, 100ms);
  EXPECT_EQ(tokens_.add(1, now_)->until() - now_, 50ms);
}

}  // namespace
}  // namespace lode::serve
