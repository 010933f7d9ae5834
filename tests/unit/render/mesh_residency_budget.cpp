// Tests of MeshResidency's memory budget: which meshes stay, which are evicted, which cuts fit.

#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "client/core/cache/mesh_cache.h"
#include "client/render/residency/mesh_residency.h"
#include "residency_fixture.h"

namespace lode::test {
namespace {

using render::MeshResidency;
using render::ResidencyOptions;

TEST_F(Residency, staysWithinItsBudgetWhateverIsShown) {
  const ResidencyOptions options{.budget_bytes = 400'000, .page_bytes = 100'000};
  MeshResidency residency(options);
  for (uint32_t seed = 1; seed < 50; ++seed) {
    residency.show(cutOf(std::vector{gridOf(seed), gridOf(seed + 1), gridOf(seed + 2, 8 + seed % 20)}));
    residency.uploadInRenderThread({.wait = true});
    EXPECT_TRUE(residency.upToDate());
    EXPECT_LE(residency.pages().capacityBytes(), options.budget_bytes);
  }
}

TEST_F(Residency, keepsOnlyTheSpareBytesOfMeshesNoLongerDrawn) {
  MeshResidency residency({.spare_bytes = 100'000});
  std::vector<std::shared_ptr<const Mesh>> alive;
  for (uint32_t seed = 1; seed < 30; ++seed) {
    alive.push_back(gridOf(seed));
    residency.show(cutOf(std::vector{alive.back()}));
    residency.uploadInRenderThread({.wait = true});
  }
  const uint64_t drawn_bytes = core::drawnBytes(*alive.back());
  EXPECT_LE(residency.pages().usedBytes(), drawn_bytes + 100'000 + 16);
  EXPECT_GT(residency.meshCount(), 1u);
}

TEST_F(Residency, evictsTheLeastRecentlyDrawnFirst) {
  const auto a = gridOf(1), b = gridOf(2), c = gridOf(3);
  MeshResidency residency({.spare_bytes = core::drawnBytes(*a) + 100});
  for (const auto& mesh : {a, b, c}) {
    residency.show(cutOf(std::vector{mesh}));
    residency.uploadInRenderThread({.wait = true});
  }
  residency.show(cutOf(std::vector{b}));
  EXPECT_EQ(residency.uploadInRenderThread({.wait = true}), 0u);
  residency.show(cutOf(std::vector{a}));
  EXPECT_EQ(residency.uploadInRenderThread({.wait = true}), core::drawnBytes(*a));
}

TEST_F(Residency, forgetsMeshesWithoutOwners) {
  MeshResidency residency({});
  for (uint32_t seed = 1; seed < 10; ++seed) {
    residency.show(cutOf(std::vector{gridOf(seed)}));
    residency.uploadInRenderThread({.wait = true});
  }
  EXPECT_LE(residency.meshCount(), 2u);
}

TEST_F(Residency, retriesATooLargeCutOnceTheBudgetGrows) {
  MeshResidency residency({.budget_bytes = 100'000, .page_bytes = 100'000});
  residency.show(cutOf(std::vector{gridOf(2), gridOf(3), gridOf(4)}));
  residency.uploadInRenderThread({.wait = true});
  ASSERT_TRUE(residency.overBudget());
  residency.setBudget(100'000);
  EXPECT_EQ(residency.uploadInRenderThread({.wait = true}), 0u) << "as much as before";
  residency.setBudget(1'000'000);
  residency.uploadInRenderThread({.wait = true});
  EXPECT_TRUE(residency.upToDate());
}

TEST_F(Residency, refusesACutAboveTheBudgetAndKeepsTheOldOne) {
  MeshResidency residency({.budget_bytes = 100'000, .page_bytes = 100'000});
  const auto small = cutOf(std::vector{gridOf(1)});
  residency.show(small);
  residency.uploadInRenderThread({.wait = true});
  residency.show(cutOf(std::vector{gridOf(2), gridOf(3), gridOf(4)}));
  residency.uploadInRenderThread({.wait = true});
  EXPECT_TRUE(residency.overBudget());
  EXPECT_FALSE(residency.upToDate());
  EXPECT_EQ(residency.drawn().size(), 1u);

  residency.show(small);
  residency.uploadInRenderThread({.wait = true});
  EXPECT_TRUE(residency.upToDate());
  EXPECT_FALSE(residency.overBudget());
}

TEST_F(Residency, exchangesWithinOneFrameTwoCutsThatDoNotFitTogether) {
  MeshResidency residency({.budget_bytes = 100'000, .page_bytes = 100'000});
  for (uint32_t seed = 1; seed < 6; ++seed) {
    const auto cut = cutOf(std::vector{gridOf(2 * seed), gridOf(2 * seed + 1)});
    residency.show(cut);
    for (int frame = 0; frame < 100 && !residency.upToDate(); ++frame) {
      residency.uploadInRenderThread({.bytes = 4000, .ms = 1000});
      if (seed > 1) {
        EXPECT_EQ(residency.drawn().size(), 2u);
      }
    }
    EXPECT_TRUE(residency.upToDate());
  }
}

TEST_F(Residency, fitsACutThatNeedsTheWholeBudgetInAnyOrderOfParts) {
  const auto small = [](uint32_t seed) { return gridOf(seed, 16); };
  const auto large = [](uint32_t seed) { return gridOf(seed, 26); };
  const auto page_bytes =
      static_cast<uint32_t>(core::drawnBytes(*small(1)) + core::drawnBytes(*large(1)) + 512);
  MeshResidency residency({.budget_bytes = 2 * page_bytes, .page_bytes = page_bytes});
  for (const auto& cut :
       {cutOf(std::vector{large(1), large(2)}), cutOf(std::vector{small(3), small(4), large(5), large(6)})}) {
    residency.show(cut);
    residency.uploadInRenderThread({.wait = true});
    EXPECT_TRUE(residency.upToDate());
  }
}

TEST_F(Residency, drawsCutsOfSevenEighthsOfItsBudgetDespiteHalfEmptyPages) {
  const uint64_t mesh_bytes = core::drawnBytes(*gridOf(1));
  const auto page_bytes = static_cast<uint32_t>(mesh_bytes * 19 / 10);
  MeshResidency residency({.budget_bytes = 8 * page_bytes, .page_bytes = page_bytes});
  std::vector<std::shared_ptr<const Mesh>> meshes;
  for (uint32_t seed = 1; (seed + 1) * mesh_bytes <= 7 * page_bytes; ++seed) meshes.push_back(gridOf(seed));
  ASSERT_GT(meshes.size(), 8u);
  for (const auto& cut : {cutOf(std::vector{gridOf(100)}), cutOf(meshes)}) {
    residency.show(cut);
    residency.uploadInRenderThread({.wait = true});
    EXPECT_TRUE(residency.upToDate());
  }
  EXPECT_LE(residency.pages().capacityBytes(), 8 * page_bytes);
}

}  // namespace
}  // namespace lode::test
