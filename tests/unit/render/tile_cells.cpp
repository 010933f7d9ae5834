#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "client/render/residency/texture_residency.h"

namespace lode::render {
namespace {

bool overlap(const TileCell& a, const TileCell& b) {
  return a.layer == b.layer && a.corner.x < b.corner.x + b.edge && b.corner.x < a.corner.x + a.edge &&
         a.corner.y < b.corner.y + b.edge && b.corner.y < a.corner.y + a.edge;
}

TEST(TileCells, neverOverlapNorLeaveTheirLayers) {
  TileCells cells(6);
  std::vector<TileCell> held;
  std::mt19937 random(3);
  for (int round = 0; round < 4000; ++round) {
    if (random() % 2 == 0 && !held.empty()) {
      std::swap(held[random() % held.size()], held.back());
      cells.release(held.back());
      held.pop_back();
      continue;
    }
    const glm::uvec2 size(1 + random() % (kTilePx >> random() % 5), 1 + random() % (kTilePx >> random() % 5));
    const auto cell = cells.allocate(size);
    if (!cell) continue;
    ASSERT_GE(cell->edge, std::max(size.x, size.y));
    ASSERT_LT(cell->layer, 6u);
    ASSERT_LE(std::max(cell->corner.x, cell->corner.y) + cell->edge, kTilePx);
    for (const TileCell& other : held) ASSERT_FALSE(overlap(*cell, other));
    held.push_back(*cell);
  }
}

TEST(TileCells, joinWhenAllAroundIsReleased) {
  TileCells cells(1);
  std::vector<TileCell> held;
  while (const auto cell = cells.allocate({20, 30})) held.push_back(*cell);
  EXPECT_EQ(held.size(), 256u);
  for (const TileCell& cell : held) cells.release(cell);
  EXPECT_TRUE(cells.allocate({kTilePx, kTilePx}));
  EXPECT_FALSE(cells.allocate({1, 1}));
}

TEST(TileCells, shareALayerBeforeTheyTakeAnother) {
  TileCells cells(4);
  for (int i = 0; i < 4; ++i) cells.allocate({256, 200});
  EXPECT_EQ(cells.layers(), 1u);
  cells.allocate({1, 1});
  EXPECT_EQ(cells.layers(), 2u);
}

}  // namespace
}  // namespace lode::render
