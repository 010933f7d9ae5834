// Lost blobs: a store damaged in single places.
#include <set>

#include "tests/support/seeds.h"
#include "tests/unit/core/refiner_on_seeds.h"

namespace lode::core {
namespace {

using namespace fixture;

class RefinerWithoutSomeBlobs : public RefinerOnSeeds {
 protected:
  /// Loses one in `share` of all blobs.
  std::set<uint32_t> someBlobs(uint32_t share) {
    std::set<uint32_t> blobs;
    const auto maybe = [&](uint32_t blob) {
      if (random_() % share == 0) blobs.insert(blob);
    };
    for (const auto& [key, node] : model_.nodes()) {
      if (node.child_page) maybe(node.child_page.number);
      for (const Lod& lod : node.lods)
        if (lod.triangles != 0) maybe(lod.payload.number);
    }
    return blobs;
  }
};

INSTANTIATE_TEST_SUITE_P(Seeds, RefinerWithoutSomeBlobs, testing::Range(1u, 1 + lode::test::kSeeds));

TEST_P(RefinerWithoutSomeBlobs, settlesOnTheBestAvailableCut) {
  for (const View& view : {closeView(), farView(), insideView()}) {
    for (const uint32_t share : {30u, 4u}) {
      const std::set<uint32_t> lost = someBlobs(share);
      Scripted client(model_);
      for (const uint32_t blob : lost) client.lose(blob);
      client.converge(view, {.threshold_px = 5}, random_, kNoCheck);
      ASSERT_TRUE(client.last().cut);
      EXPECT_TRUE(client.last().settled);
      EXPECT_LE(client.last().cut->refinable_px, 5) << "nothing more can be had";
      EXPECT_EQ(partsOf(*client.last().cut), BruteForce(model_, view, 5, lost).parts());
    }
  }
}

TEST_P(RefinerWithoutSomeBlobs, beginsBelowARootWithoutAvailableLods) {
  std::set<uint32_t> lost;
  for (const Lod& lod : model_.nodes().at(kRootKey).lods) lost.insert(lod.payload.number);
  Scripted client(model_);
  for (const uint32_t blob : lost) client.lose(blob);
  client.converge(farView(), {.threshold_px = 1000}, random_, kNoCheck);
  ASSERT_TRUE(client.last().cut);
  EXPECT_EQ(partsOf(*client.last().cut), BruteForce(model_, farView(), 1000, lost).parts());
}

TEST_P(RefinerWithoutSomeBlobs, doesNotConvergeIfTheErrorStaysAboveTheThreshold) {
  std::set<uint32_t> lost;
  for (const auto& [key, node] : model_.nodes())
    for (const Lod& lod : node.lods)
      if (key.depth() >= 1 && lod.triangles != 0) lost.insert(lod.payload.number);
  Scripted client(model_);
  for (const uint32_t blob : lost) client.lose(blob);
  client.converge(closeView(), {.threshold_px = 1}, random_, kNoCheck);
  EXPECT_EQ(partsOf(*client.last().cut), (Parts{{kRootKey, 0}}));
  EXPECT_FALSE(client.last().cut->converged);
  EXPECT_TRUE(client.last().settled);
}

}  // namespace
}  // namespace lode::core
