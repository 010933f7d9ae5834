#include "server/ingest/mesh/four_vectors.h"

#include <algorithm>
#include <array>

#include <gtest/gtest.h>

namespace lode::ingest {
namespace {

TEST(FourVectors, setABitForEachTrueComparison) {
  for (unsigned bits = 0; bits < 16; ++bits) {
    Four four{};
    for (unsigned k = 0; k < 4; ++k) four[k] = (bits >> k & 1) != 0 ? -1.f : 1.f;
    EXPECT_EQ(bitsOf(four < 0), bits);
    EXPECT_EQ(anyOf(four < 0), bits != 0);
  }
}

TEST(FourVectors, findTheLeastNumberInAnySlot) {
  std::array<float, 4> numbers{1, 2, 3, 4};
  do {
    EXPECT_EQ(leastOf(Four{numbers[0], numbers[1], numbers[2], numbers[3]}), 1);
  } while (std::next_permutation(numbers.begin(), numbers.end()));
}

}  // namespace
}  // namespace lode::ingest
