#include "server/serve/memory/trim_watch.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace lode::serve {
namespace {

using namespace std::chrono_literals;

constexpr uint64_t kProgram = 10u << 20, kMuch = 16 * TrimWatch::kLeastBytes;

class TrimWatchTest : public testing::Test {
 protected:
  bool isTime(uint64_t resident_bytes, uint64_t used_bytes) {
    now_ += TrimWatch::kEvery;
    return watch_.isTime(resident_bytes, used_bytes, now_);
  }

  TrimWatch watch_;
  TrimWatch::Time now_{1000s};
};

TEST_F(TrimWatchTest, isTimeWhenWhatWasHeldStaysResident) {
  EXPECT_FALSE(isTime(kProgram, 0));
  EXPECT_FALSE(isTime(kProgram + kMuch, kMuch));
  EXPECT_TRUE(isTime(kProgram + kMuch, 0));
  EXPECT_FALSE(isTime(kProgram, 0));
}

TEST_F(TrimWatchTest, isTimeAfterAFloodThatCameAndWentBetweenTwoLooks) {
  EXPECT_FALSE(isTime(kProgram, 0));
  EXPECT_TRUE(isTime(kProgram + kMuch, 0));
}

TEST_F(TrimWatchTest, doesNotTryInVainForEver) {
  EXPECT_FALSE(isTime(kProgram, 0));
  EXPECT_TRUE(isTime(kProgram + kMuch, 0));
  for (int i = 0; i < 10; ++i) EXPECT_FALSE(isTime(kProgram + kMuch, 0)) << "it stayed the first time";
  EXPECT_FALSE(isTime(kProgram, 0));
  EXPECT_TRUE(isTime(kProgram + kMuch, 0)) << "what goes by itself comes anew";
}

TEST_F(TrimWatchTest, triesAgainWhenWhatLayBetweenHasComeBackToo) {
  EXPECT_FALSE(isTime(kProgram, 0));
  EXPECT_TRUE(isTime(kProgram + kMuch, kMuch / 2));
  EXPECT_FALSE(isTime(kProgram + kMuch, kMuch / 2)) << "all of it lay between what is in use";
  EXPECT_FALSE(isTime(kProgram + 3 * kMuch / 4, kMuch / 4));
  EXPECT_TRUE(isTime(kProgram + kMuch / 2, 0));
  EXPECT_FALSE(isTime(kProgram + kMuch / 2, 0));
}

TEST_F(TrimWatchTest, doesNotMindALittle) {
  EXPECT_FALSE(isTime(kProgram, 0));
  EXPECT_FALSE(isTime(kProgram + TrimWatch::kLeastBytes - 1, 0));
}

TEST_F(TrimWatchTest, isDueAgainAfterAWhile) {
  EXPECT_TRUE(watch_.due(now_));
  isTime(kProgram, 0);
  EXPECT_FALSE(watch_.due(now_));
  EXPECT_TRUE(watch_.due(now_ + TrimWatch::kEvery));
}

TEST(AnonymousResidentBytes, growByWhatIsTouched) {
  const uint64_t before = anonymousResidentBytes();
  const std::vector<char> touched(kMuch, 'x');
  EXPECT_GE(anonymousResidentBytes(), before + kMuch / 2);
}

#ifndef LODE_SANITIZED  // whose allocators malloc's figures know nothing of
TEST(AllocatedBytes, areThoseThatWereNotFreed) {
  const uint64_t before = allocatedBytes();
  {
    const std::vector<char> large(kMuch);
    const std::vector<std::string> small(1000, std::string(1000, 'x'));
    EXPECT_GE(allocatedBytes(), before + kMuch + 1000 * 1000);
  }
  EXPECT_LT(allocatedBytes(), before + kMuch / 4);
}
#endif

}  // namespace
}  // namespace lode::serve
