#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "client/render/residency/gpu_pages.h"

namespace lode::render {
namespace {

TEST(BlockAllocator, neverHandsOutOverlappingRanges) {
  constexpr uint32_t kCapacity = 10'000;
  BlockAllocator allocator(kCapacity);
  std::vector<std::pair<uint32_t, uint32_t>> held;
  std::mt19937 random(7);
  for (int round = 0; round < 5000; ++round) {
    if (random() % 2 == 0 && !held.empty()) {
      std::swap(held[random() % held.size()], held.back());
      allocator.release(held.back().first, held.back().second);
      held.pop_back();
      continue;
    }
    const uint32_t bytes = 1 + static_cast<uint32_t>(random() % 700);
    const auto offset = allocator.allocate(bytes);
    if (!offset) continue;
    ASSERT_EQ(*offset % BlockAllocator::kAlignment, 0u);
    ASSERT_LE(*offset + bytes, kCapacity);
    for (const auto& [other, other_bytes] : held) {
      ASSERT_TRUE(*offset + bytes <= other || other + other_bytes <= *offset);
    }
    held.emplace_back(*offset, bytes);
  }
}

TEST(BlockAllocator, joinsReleasedRangesInAnyOrder) {
  for (const auto& order : {std::vector{0, 1, 2}, std::vector{2, 1, 0}, std::vector{0, 2, 1}}) {
    BlockAllocator allocator(300);
    std::vector<uint32_t> offsets;
    for (int i = 0; i < 3; ++i) offsets.push_back(allocator.allocate(96).value());
    EXPECT_FALSE(allocator.allocate(16));
    for (const int i : order) allocator.release(offsets[static_cast<size_t>(i)], 96);
    EXPECT_TRUE(allocator.empty());
    EXPECT_TRUE(allocator.allocate(288));
  }
}

TEST(BlockAllocator, fillsTheTightestGap) {
  BlockAllocator allocator(1600);
  const uint32_t wide = allocator.allocate(480).value();
  allocator.allocate(16);
  const uint32_t tight = allocator.allocate(64).value();
  allocator.allocate(16);
  allocator.release(wide, 480);
  allocator.release(tight, 64);
  EXPECT_EQ(allocator.allocate(60), tight);
}

}  // namespace
}  // namespace lode::render
