#include "client/core/lod/view_group.h"

#include <algorithm>
#include <limits>
#include <map>

#include "client/core/cache/mesh_cache.h"
#include "tests/unit/core/seeded_model.h"

namespace lode::core {
namespace {

using namespace fixture;

class ViewGroupOnSeeds : public testing::TestWithParam<uint32_t>, protected Seeded {
 protected:
  ViewGroupOnSeeds() : Seeded(GetParam()) {}
};

INSTANTIATE_TEST_SUITE_P(Seeds, ViewGroupOnSeeds, testing::Range(1u, 7u));

const View kFront = lookingAt({512, 512, 2500}, {512, 512, 512}),
           kBack = lookingAt({512, 512, -1500}, {512, 512, 512});

TEST_P(ViewGroupOnSeeds, requestsForTheCurrentViewWhateverWasSeenBefore) {
  ViewGroup turned = seeing(kFront);
  deliverBest(turned, 10);
  turned.setView(kBack, 1);
  turned.refine(model_);
  ViewGroup fresh = seeing(kBack);
  fresh.refine(model_);
  EXPECT_EQ(orderOf(turned), orderOf(fresh));
}

TEST_P(ViewGroupOnSeeds, requestsForTwoViewsWhateverOneHadSeenAlone) {
  const View both[] = {kBack, kFront};
  ViewGroup joined = seeing(kFront), fresh;
  deliverBest(joined, 10);
  for (ViewGroup* group : {&joined, &fresh}) {
    group->setViews(both, 1);
    group->refine(model_);
  }
  EXPECT_EQ(orderOf(joined), orderOf(fresh));
}

TEST_P(ViewGroupOnSeeds, updatesVisibilityAsTheCutBecomesFiner) {
  ViewGroup early = seeing(kFront);
  early.refine(model_);
  const uint64_t first_triangles = early.cut()->triangles;
  while (early.cut()->triangles < 2 * first_triangles && !early.requests().empty()) deliverBest(early, 1);
  ViewGroup late = seeing(kFront);
  late.refine(model_);
  EXPECT_EQ(orderOf(early), orderOf(late));
}

TEST_P(ViewGroupOnSeeds, refinesAgainOnlyWithMemoryToSpare) {
  ViewGroup group({.shares_memory = true});
  group.setView(kFront, 1);
  const auto partsWithin = [&](uint64_t drawn_budget_bytes) {
    group.setDrawnBudget(drawn_budget_bytes);
    deliverBest(group, std::numeric_limits<int>::max());
    return partsOf(*group.cut());
  };
  const Parts liked = partsWithin(std::numeric_limits<uint64_t>::max());
  const uint64_t liked_bytes = group.cut()->drawn_bytes;
  const Parts held = partsWithin(liked_bytes / 2);
  EXPECT_TRUE(group.limited());
  EXPECT_NE(held, liked);
  for (const uint64_t sixteenths : {9, 10, 8}) EXPECT_EQ(partsWithin(liked_bytes * sixteenths / 16), held);
  EXPECT_EQ(partsWithin(2 * liked_bytes), liked);
  EXPECT_FALSE(group.limited());
}

/// A camera inside a model whose threshold was raised: its cut contains finer stand-ins and fallbacks.
class Within : private Seeded {
 public:
  explicit Within(uint32_t seed) : Seeded(seed) {
    ViewGroup far;
    far.setView(farView(), 5);
    deliverBest(far, std::numeric_limits<int>::max());
    for (ViewGroup group = within(1, {}); sees(group); group.refine(model_))
      deliver(group.requests().front());
  }

  /// Returns the cut within a budget.
  std::shared_ptr<const Cut> cutAt(uint64_t drawn_budget_bytes, bool& limited) {
    const ViewGroup group = within(30, {.drawn_budget_bytes = drawn_budget_bytes});
    limited = group.limited();
    return group.cut();
  }

  /// Memory of the fallback that is never dropped.
  uint64_t leastFallbackBytes() const {
    const auto lods = static_cast<uint32_t>(tree_.nodes().at(kRootKey).lods.size());
    return drawnBytes(*tree_.mesh({kRootKey, lods - 1}));
  }

 private:
  ViewGroup within(float threshold_px, const RefineOptions& options) {
    ViewGroup group(options);
    group.setView(insideView(), threshold_px);
    group.refine(model_);
    return group;
  }
  static bool sees(const ViewGroup& group) {
    return !group.requests().empty() &&
           group.requests().front().request_class == proto::RequestClass::kVisible;
  }
};

uint64_t bytesOfParts(const Cut& cut) {
  uint64_t bytes = 0;
  for (const CutPart& part : cut.parts) bytes += drawnBytes(*part.mesh);
  return bytes;
}

TEST(ViewGroup, dropsFallbacksBeforeVisibleDetail) {
  int without_fallbacks = 0,
      without_finer = 0;  // numbers of budgets
  for (uint32_t seed = 1; seed < 7; ++seed) {
    Within camera(seed);
    bool limited = false;
    const std::shared_ptr<const Cut> liked = camera.cutAt(std::numeric_limits<uint64_t>::max(), limited);
    for (uint64_t budget = liked->drawn_bytes; !limited; budget -= budget / 50) {
      const std::shared_ptr<const Cut> cut = camera.cutAt(budget, limited);
      if (limited) break;
      EXPECT_LE(cut->drawn_bytes, budget) << seed;
      const bool is_as_fine = partsOf(*cut) == partsOf(*liked);
      const bool could_be = bytesOfParts(*liked) + camera.leastFallbackBytes() <= budget;
      EXPECT_TRUE(is_as_fine || !could_be) << seed;
      without_fallbacks += is_as_fine && cut->drawn_bytes < liked->drawn_bytes;
      without_finer += !is_as_fine;
    }
  }
  EXPECT_GT(without_fallbacks, 0);
  EXPECT_GT(without_finer, 0);
}

/// A camera whose cuts are checked after every blob.
class Watched : private Seeded {
 public:
  Watched(uint32_t seed, uint64_t drawn_budget_bytes)
      : Seeded(seed), group_({.drawn_budget_bytes = drawn_budget_bytes}) {}

  /// Moves away from the model, to a view that needs coarser LODs and nodes not seen before.
  static Watched steppingBack(uint32_t seed, uint64_t drawn_budget_bytes) {
    Watched camera(seed, drawn_budget_bytes);
    camera.see(closeView(), 4);
    camera.watch([](const Cut&) {});
    camera.see(kFront, 6);
    return camera;
  }

  void see(const View& view, float threshold_px) { group_.setView(view, threshold_px); }

  /// Delivers all blobs and calls see(cut) after each.
  template <typename See>
  void watch(See&& see) {
    for (group_.refine(model_);; group_.refine(model_)) {
      see(*group_.cut());
      if (group_.requests().empty()) return;
      deliver(group_.requests().front());
    }
  }

  /// Returns the largest number of times that one node becomes coarser meanwhile.
  int mostRises() {
    std::map<NodeKey, int> rises;
    std::map<NodeKey, float> before;
    watch([&](const Cut& cut) {
      const Parts parts = partsOf(cut);
      for (const NodeKey leaf : tree_.leaves()) {
        const auto shown = partAt(parts, leaf);
        if (shown == parts.end()) continue;
        const float error_model = tree_.nodes().at(shown->first).lods[shown->second].error_model;
        const auto [was, is_first] = before.emplace(leaf, error_model);
        rises[leaf] += !is_first && error_model > was->second;
        was->second = error_model;
      }
    });
    int most = 0;
    for (const auto& [leaf, count] : rises) most = std::max(most, count);
    return most;
  }

  const ViewGroup& group() const { return group_; }

 private:
  static Parts::const_iterator partAt(const Parts& parts, NodeKey place) {
    for (int depth = place.depth(); depth >= 0; --depth)
      if (const auto found = parts.find(place.ancestorAt(depth)); found != parts.end()) return found;
    return parts.end();
  }

  ViewGroup group_;
};

TEST(ViewGroup, doesNotRestoreDroppedDetailOnEachArrival) {
  int most = 0;
  for (uint32_t seed = 1; seed < 7; ++seed) {
    auto unlimited = Watched::steppingBack(seed, std::numeric_limits<uint64_t>::max());
    unlimited.mostRises();
    const uint64_t liked = unlimited.group().cut()->drawn_bytes;
    for (uint64_t budget = liked; budget < 5 * liked / 4; budget += liked / 16)
      most = std::max(most, Watched::steppingBack(seed, budget).mostRises());
  }
  EXPECT_LE(most, 2);
}

}  // namespace
}  // namespace lode::core
