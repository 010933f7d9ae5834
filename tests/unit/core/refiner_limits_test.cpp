// What budgets and hysteresis make of a refinement.

#include "tests/unit/core/scripted_client.h"

namespace lode::core {
namespace {

using namespace test;

class RefinerLimits : public testing::TestWithParam<uint32_t> {
 protected:
  SyntheticModel model_{{.seed = GetParam(), .empty_chance = GetParam() % 2 ? 0.1 : 0.0}};
  std::mt19937 random_{GetParam() * 7919};
};

INSTANTIATE_TEST_SUITE_P(Seeds, RefinerLimits, testing::Range(1u, 13u));

TEST_P(RefinerLimits, showsAllOfEachPlaceInTurnThoughTheBudgetHoldsThePagesOfOneAlone) {
  const auto pagesOf = [&](const View& view) {
    Scripted client(model_);
    client.converge(view, {.threshold_px = 4}, random_, kNoCheck);
    return client.hierarchy().bytes();
  };
  const uint64_t budget =
      std::max({pagesOf(closeView()), pagesOf(insideView()), pagesOf(farView())}) + pageBytesAtMost(1000);
  Scripted client(model_);
  for (const View& view : {closeView(), insideView(), farView(), insideView(), closeView()}) {
    client.converge(view, {.threshold_px = 4, .hierarchy_budget_bytes = budget}, random_, kNoCheck);
    EXPECT_TRUE(client.last().cut->converged);
    EXPECT_LE(client.hierarchy().bytes(), budget);
    EXPECT_EQ(partsOf(*client.last().cut), BruteForce(model_, view, 4).parts());
  }
}

TEST(Refiner, countsPartsWithoutTrianglesInTheMemoryToo) {
  HierarchyPage page;
  const auto add = [&](NodeKey key, uint8_t children, float error_model) {
    Node node;
    node.key = key;
    node.box.add(glm::uvec3(0));
    node.box.add(glm::uvec3(1024));
    node.child_mask = children;
    node.rungs = {{{}, 0, 0, 0, error_model, 0}};
    page.nodes.push_back(node);
  };
  add(kRootKey, 0xff, 100);
  for (unsigned octant = 0; octant < 8; ++octant) add(kRootKey.child(octant), 0xff, 90);
  for (unsigned parent = 0; parent < 8; ++parent)
    for (unsigned octant = 0; octant < 8; ++octant) add(kRootKey.child(parent).child(octant), 0, 80);
  Hierarchy hierarchy(page.nodes.size());
  hierarchy.addRootPage(page);
  const MeshCache cache(1u << 20);
  const View view = lookingAt({512, 512, 2000}, {512, 512, 0});
  const auto limitedBy = [&](uint64_t budget_bytes) {
    return refine(hierarchy, cache, {{0, 0, 0}, 1}, {}, view,
                  {.threshold_px = 2, .cut_budget_bytes = budget_bytes})
        .limited;
  };
  EXPECT_TRUE(limitedBy(8 * kPartBytes));
  EXPECT_FALSE(limitedBy(64 * kPartBytes));
}

/// Sees all of the model, so that only distances change.
View viewFrom(double distance) { return lookingAt({512, 512, 512 + distance}, {512, 512, 512}); }

TEST(Refiner, changesNothingForACameraThatTremblesOnceItHasSeenBothEnds) {
  const auto partsAt = [](Scripted& client, double distance, float hold_factor, std::mt19937& random) {
    client.converge(viewFrom(distance), {.threshold_px = 12, .hold_factor = hold_factor}, random, kNoCheck);
    return partsOf(*client.last().cut);
  };
  size_t flickering = 0;  // models that change without hysteresis
  for (uint32_t seed = 1; seed < 13; ++seed) {
    const SyntheticModel model({.seed = seed});
    std::mt19937 random(seed);
    Scripted held(model), plain(model);
    partsAt(held, 3000, kHoldFactor, random);
    const Parts nearest = partsAt(held, 2700, kHoldFactor, random);
    for (const double distance : {3000., 2900., 2700., 2800., 3000.})
      EXPECT_EQ(partsAt(held, distance, kHoldFactor, random), nearest);
    flickering += partsAt(plain, 3000, 1, random) != partsAt(plain, 2700, 1, random);
  }
  EXPECT_GT(flickering, 0u);
}

TEST(Refiner, letsGoOfWhatItHoldsWhereTheErrorHasFallenByMoreThanThat) {
  const SyntheticModel model({.seed = 3});
  std::mt19937 random(3);
  Scripted held(model), fresh(model);
  for (const double distance : {2800., 6000.})
    held.converge(viewFrom(distance), {.threshold_px = 4, .hold_factor = kHoldFactor}, random, kNoCheck);
  fresh.converge(viewFrom(6000), {.threshold_px = 4 * kHoldFactor}, random, kNoCheck);
  EXPECT_LE(held.last().cut->triangles, fresh.last().cut->triangles);
}

}  // namespace
}  // namespace lode::core
