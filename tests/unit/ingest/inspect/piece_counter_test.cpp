#include "server/ingest/inspect/piece_counter.h"

#include <algorithm>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace lode::ingest {
namespace {

constexpr uint64_t kOneRange = 1 << 20, kSmallestRanges = 0;  ///< memory budgets in bytes

uint64_t joinsOf(uint32_t vertices, const std::vector<std::pair<uint32_t, uint32_t>>& pairs,
                 uint64_t memory_bytes) {
  const TemporaryFolder folder(::testing::TempDir());
  PieceCounter counter(vertices, memory_bytes, folder);
  for (const auto& [a, b] : pairs) counter.join(a, b);
  return counter.countJoins();
}

TEST(PieceCounter, countsAChainOnceInAnyOrder) {
  std::vector<std::pair<uint32_t, uint32_t>> chain;
  for (uint32_t i = 1; i < 10000; ++i) chain.emplace_back(i, i - 1);
  EXPECT_EQ(joinsOf(10000, chain, kSmallestRanges), 9999u);
  std::ranges::reverse(chain);
  EXPECT_EQ(joinsOf(10000, chain, kSmallestRanges), 9999u);
}

TEST(PieceCounter, doesNotCountJoinsThatCloseARingAcrossRanges) {
  EXPECT_EQ(
      joinsOf(5000, {{4999, 3000}, {4998, 100}, {4999, 4998}, {3000, 100}, {4999, 100}}, kSmallestRanges),
      3u);
}

TEST(PieceCounter, findsTheSameInManyRangesAsInOne) {
  for (const uint32_t seed : {1u, 2u, 3u, 4u}) {
    std::mt19937 engine(seed);
    const auto random = [&] { return static_cast<uint32_t>(engine()); };
    constexpr uint32_t kVertices = 20000;
    std::vector<std::pair<uint32_t, uint32_t>> pairs;
    for (uint32_t i = 0; i < kVertices * seed / 3; ++i) {
      const uint32_t a = random() % kVertices;
      pairs.emplace_back(a, i % 2 == 0 ? random() % kVertices : std::min(a + 1, kVertices - 1));
    }
    EXPECT_EQ(joinsOf(kVertices, pairs, kSmallestRanges), joinsOf(kVertices, pairs, kOneRange)) << seed;
  }
}

TEST(PieceCounter, acceptsNoVertices) { EXPECT_EQ(joinsOf(0, {}, kSmallestRanges), 0u); }

}  // namespace
}  // namespace lode::ingest
