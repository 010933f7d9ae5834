#include "server/ingest/partition/leaf_cutter.h"

#include <algorithm>
#include <map>
#include <random>

#include <gtest/gtest.h>

#include "common/error.h"
#include "common/limits.h"
#include "server/ingest/mesh/cell_code.h"

namespace lode::ingest {
namespace {

using Leaves = std::vector<std::pair<NodeKey, uint32_t>>;

Leaves cut(const std::vector<uint64_t>& codes, uint32_t max_triangles) {
  Leaves leaves;
  LeafCutter cutter(1, max_triangles,
                    [&](NodeKey key, std::span<const std::byte> records, uint32_t triangles) {
                      EXPECT_EQ(records.size(), triangles);
                      leaves.emplace_back(key, triangles);
                    });
  const std::byte record{};
  for (const uint64_t code : codes) cutter.push(code, {&record, 1});
  cutter.finish();
  return leaves;
}

/// Reference implementation: splits cells from the root while they hold too many triangles.
void split(const std::vector<uint64_t>& codes, NodeKey key, size_t begin, size_t end, uint32_t max,
           Leaves& leaves) {
  if (begin == end) return;
  if (end - begin <= max) {
    leaves.emplace_back(key, static_cast<uint32_t>(end - begin));
    return;
  }
  for (unsigned octant = 0; octant < 8; ++octant) {
    size_t next = begin;
    while (next < end && cellAt(codes[next], key.depth() + 1) == key.child(octant)) ++next;
    split(codes, key.child(octant), begin, next, max, leaves);
    begin = next;
  }
}

std::vector<uint64_t> randomCodes(size_t count, int clusters) {
  std::mt19937_64 random(11);
  std::vector<uint64_t> codes;
  for (size_t i = 0; i < count; ++i) {
    const uint64_t cluster = (random() % clusters) << 50;
    codes.push_back((cluster | random() >> (4 + random() % 40)) & ((1ull << 60) - 1));
  }
  std::sort(codes.begin(), codes.end());
  return codes;
}

TEST(LeafCutter, cutsTheSameLeavesAsSplittingFromTheRoot) {
  for (const uint32_t max : {1u, 7u, 64u, 5000u}) {
    std::vector<uint64_t> codes = randomCodes(4000, 30);
    codes.erase(std::unique(codes.begin(), codes.end()), codes.end());
    Leaves expected;
    split(codes, kRootKey, 0, codes.size(), max, expected);
    EXPECT_EQ(cut(codes, max), expected) << max;
  }
}

TEST(LeafCutter, allowsMoreThanTheMaximumInACellOfTheFinestLevel) {
  std::vector<uint64_t> codes(1000, 12345);
  codes.push_back(999999);
  const Leaves leaves = cut(codes, 10);
  ASSERT_EQ(leaves.size(), 2u);
  EXPECT_EQ(leaves[0].first.depth(), kMaxDepth);
  EXPECT_EQ(leaves[0].second, 1000u);
}

TEST(LeafCutter, refusesMoreTrianglesInOneFinestCellThanALodMayHave) {
  try {
    cut(std::vector<uint64_t>(kMaxLodTriangles + 1, 5), 10);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInput) << "to try again is of no use";
    EXPECT_NE(std::string_view(error.what()).find(std::to_string(cellAt(5, kMaxDepth).value)),
              std::string_view::npos);
  }
  EXPECT_NO_THROW(cut(std::vector<uint64_t>(kMaxLodTriangles, 5), 10));
}

TEST(CellCode, commonDepthIsTheDepthOfTheDeepestSharedCell) {
  std::mt19937_64 random(5);
  for (int i = 0; i < 2000; ++i) {
    const uint64_t a = random() >> 4, b = a ^ (random() >> (4 + random() % 60));
    const int depth = commonDepth(a, b);
    EXPECT_EQ(cellAt(a, depth), cellAt(b, depth));
    if (depth < kMaxDepth) {
      EXPECT_NE(cellAt(a, depth + 1), cellAt(b, depth + 1));
    }
  }
}

}  // namespace
}  // namespace lode::ingest
