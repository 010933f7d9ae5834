#include "common/release_storage.h"

#include <vector>

#include <gtest/gtest.h>

namespace lode {
namespace {

TEST(LetGo, freesTheMemoryOfAContainer) {
  std::vector<int> numbers(1000, 7);
  releaseStorage(numbers);
  EXPECT_TRUE(numbers.empty());
  EXPECT_EQ(numbers.capacity(), 0u);
}

}  // namespace
}  // namespace lode
