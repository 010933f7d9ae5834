#include "client/app/window/settings.h"

#include <gtest/gtest.h>

namespace lode::app {
namespace {

TEST(Settings, haveTheMemoryStepThatIsNearestByItsRatio) {
  EXPECT_EQ(kMemorySteps[memoryStepAt(uint64_t{1} << 30)], 1'000'000'000u);
  EXPECT_EQ(kMemorySteps[memoryStepAt(1'500'000'000)], 2'000'000'000u);
  EXPECT_EQ(memoryStepAt(1), 0u);
  EXPECT_EQ(memoryStepAt(uint64_t{1} << 50), kMemorySteps.size() - 1);
  for (size_t step = 0; step < kMemorySteps.size(); ++step) EXPECT_EQ(memoryStepAt(kMemorySteps[step]), step);
}

}  // namespace
}  // namespace lode::app
