#include "server/tiles/lod_chain.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace lode::tiles {
namespace {

constexpr double kFarAbove = 1e9;

/// Returns a node with LODs of given triangles and errors, finest first.
Node nodeWith(const std::vector<std::pair<uint32_t, float>>& lods, uint32_t far_lods = 0) {
  Node node;
  node.child_mask = 1;
  node.far_lods = far_lods;
  for (const auto& [triangles, error] : lods) {
    Lod& lod = node.lods.emplace_back();
    lod.triangles = triangles;
    lod.error_model = error;
  }
  return node;
}

std::vector<uint32_t> lodsOf(const std::vector<TileLod>& chain) {
  std::vector<uint32_t> lods;
  for (const TileLod& tile : chain) lods.push_back(tile.lod);
  return lods;
}

TEST(TileChain, goesFromTheCoarsestLodToTheFinest) {
  const auto chain = tileChain(nodeWith({{4000, 1}, {2000, 2}, {1000, 4}}), kFarAbove);
  EXPECT_EQ(chain, (std::vector<TileLod>{{2, 4}, {1, 2}, {0, 1}}));
}

TEST(TileChain, leavesOutFarLods) {
  EXPECT_EQ(lodsOf(tileChain(nodeWith({{4000, 1}, {2000, 2}, {1000, 40}}, 1), kFarAbove)),
            (std::vector<uint32_t>{1, 0}));
}

TEST(TileChain, leavesOutLodsThatDifferLittleInTrianglesOrError) {
  EXPECT_EQ(lodsOf(tileChain(nodeWith({{4000, 1}, {3000, 3}, {2000, 4}, {900, 8}}), kFarAbove)),
            (std::vector<uint32_t>{3, 2, 0}));
  EXPECT_EQ(lodsOf(tileChain(nodeWith({{4000, 1}, {2000, 1.5}, {1000, 2}, {400, 5}}), kFarAbove)),
            (std::vector<uint32_t>{3, 2, 0}));
}

TEST(TileChain, keepsTheFirstAndTheLastLodEvenIfTheyDifferLittle) {
  EXPECT_EQ(lodsOf(tileChain(nodeWith({{4000, 1}, {3900, 1.1f}}), kFarAbove)), (std::vector<uint32_t>{1, 0}));
}

TEST(TileChain, usesTheLargerOfTheTwoErrors) {
  Node node = nodeWith({{4000, 1}});
  node.lods[0].appearance_error_model = 3;
  EXPECT_EQ(tileChain(node, kFarAbove).front().error_model, 3);
}

TEST(TileChain, keepsTheErrorOfALeaf) {
  Node leaf = nodeWith({{100, 0.25f}});
  leaf.child_mask = 0;
  EXPECT_EQ(tileChain(leaf, kFarAbove), (std::vector<TileLod>{{0, 0.25}}));
}

TEST(TileChain, hasStrictlyFallingErrors) {
  double above = 2;
  for (int node = 0; node < 20; ++node)
    for (const TileLod& tile : tileChain(nodeWith({{4000, 2}, {2000, 2}, {1000, 2}}), above)) {
      EXPECT_LT(tile.error_model, above);
      EXPECT_GT(tile.error_model, above * (1 - 2e-6));
      above = tile.error_model;
    }
}

TEST(TileChain, endsAtAnErrorOfZero) {
  const Node node = nodeWith({{4000, 0}, {2000, 0}, {1000, 1}});
  const auto chain = tileChain(node, kFarAbove);
  EXPECT_EQ(chain.back().error_model, 0);
  EXPECT_EQ(std::ranges::count(chain, 0, &TileLod::error_model), 1);
  EXPECT_FALSE(continuesBelow(node, chain));
}

TEST(TileChain, continuesBelowANodeWithChildrenAndAnError) {
  Node node = nodeWith({{4000, 1}});
  EXPECT_TRUE(continuesBelow(node, tileChain(node, kFarAbove)));
  node.child_mask = 0;
  EXPECT_FALSE(continuesBelow(node, tileChain(node, kFarAbove)));
}

TEST(NineDigits, keepFloatsApart) {
  for (float value = 1e-30f; value < 1e30f; value *= 1.37f) {
    const float next = std::nextafter(value, 2e30f);
    EXPECT_LT(toNineDigits(value), toNineDigits(next));
    EXPECT_EQ(static_cast<float>(toNineDigits(value)), value);
  }
}

TEST(NineDigits, areNoMore) {
  EXPECT_EQ(toNineDigits(1.0 / 3), 0.333333333);
  EXPECT_EQ(toNineDigits(123456789012.0), 123456789000.0);
  EXPECT_EQ(toNineDigits(0), 0);
}

}  // namespace
}  // namespace lode::tiles
