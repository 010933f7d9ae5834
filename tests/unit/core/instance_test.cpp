#include "client/core/instance.h"

#include <algorithm>
#include <limits>
#include <map>

#include "client/core/drawn_bytes.h"
#include "tests/unit/core/seeded_model.h"

namespace lode::core {
namespace {

using namespace fixture;

class InstanceOnSeeds : public testing::TestWithParam<uint32_t>, protected Seeded {
 protected:
  InstanceOnSeeds() : Seeded(GetParam()) {}
};

INSTANTIATE_TEST_SUITE_P(Seeds, InstanceOnSeeds, testing::Range(1u, 7u));

const View kFront = lookingAt({512, 512, 2500}, {512, 512, 512}),
           kBack = lookingAt({512, 512, -1500}, {512, 512, 512});

TEST_P(InstanceOnSeeds, asksForWhatIsSeenByTheViewAtHandWhateverWasSeenBefore) {
  Instance turned = seeing(kFront);
  deliverBest(turned, 10);
  turned.setView(kBack, 1);
  turned.refine(model_);
  Instance fresh = seeing(kBack);
  fresh.refine(model_);
  EXPECT_EQ(orderOf(turned), orderOf(fresh));
}

TEST_P(InstanceOnSeeds, asksForWhatIsSeenByTwoViewsWhateverOneHadSeenAlone) {
  const View both[] = {kBack, kFront};
  Instance joined = seeing(kFront), fresh;
  deliverBest(joined, 10);
  for (Instance* instance : {&joined, &fresh}) {
    instance->setViews(both, 1);
    instance->refine(model_);
  }
  EXPECT_EQ(orderOf(joined), orderOf(fresh));
}

TEST_P(InstanceOnSeeds, looksAnewAtWhatIsSeenAsTheCutBecomesFiner) {
  Instance early = seeing(kFront);
  early.refine(model_);
  const uint64_t first_triangles = early.cut()->triangles;
  while (early.cut()->triangles < 2 * first_triangles && !early.requests().empty()) deliverBest(early, 1);
  Instance late = seeing(kFront);
  late.refine(model_);
  EXPECT_EQ(orderOf(early), orderOf(late));
}

TEST_P(InstanceOnSeeds, becomesFinerAgainOnlyWhereThereIsRoomToSpare) {
  Instance instance({.lists_wanted = true});
  instance.setView(kFront, 1);
  const auto partsWithin = [&](uint64_t drawn_budget_bytes) {
    instance.setDrawnBudget(drawn_budget_bytes);
    deliverBest(instance, std::numeric_limits<int>::max());
    return partsOf(*instance.cut());
  };
  const Parts liked = partsWithin(std::numeric_limits<uint64_t>::max());
  const uint64_t liked_bytes = instance.cut()->drawn_bytes;
  const Parts held = partsWithin(liked_bytes / 2);
  EXPECT_TRUE(instance.limited());
  EXPECT_NE(held, liked);
  for (const uint64_t sixteenths : {9, 10, 8}) EXPECT_EQ(partsWithin(liked_bytes * sixteenths / 16), held);
  EXPECT_EQ(partsWithin(2 * liked_bytes), liked);
  EXPECT_FALSE(instance.limited());
}

/// A camera within a model that asks for less than it did: what it sees is finer than it wants, and something
/// stands by for what it leaves out.
class Within : private Seeded {
 public:
  explicit Within(uint32_t seed) : Seeded(seed) {
    Instance far;
    far.setView(farView(), 5);
    deliverBest(far, std::numeric_limits<int>::max());
    for (Instance instance = within(1, {}); sees(instance); instance.refine(model_))
      deliver(instance.requests().front());
  }

  /// What such a camera is given.
  std::shared_ptr<const Cut> cutAt(uint64_t drawn_budget_bytes, bool& limited) {
    const Instance instance = within(30, {.drawn_budget_bytes = drawn_budget_bytes});
    limited = instance.limited();
    return instance.cut();
  }

  /// Of the fallback that is never given up.
  uint64_t leastFallbackBytes() const {
    const auto lods = static_cast<uint32_t>(tree_.nodes().at(kRootKey).lods.size());
    return drawnBytes(*tree_.mesh({kRootKey, lods - 1}));
  }

 private:
  Instance within(float threshold_px, const RefineOptions& options) {
    Instance instance(options);
    instance.setView(insideView(), threshold_px);
    instance.refine(model_);
    return instance;
  }
  static bool sees(const Instance& instance) {
    return !instance.requests().empty() &&
           instance.requests().front().request_class == proto::RequestClass::kVisible;
  }
};

uint64_t bytesOfParts(const Cut& cut) {
  uint64_t bytes = 0;
  for (const CutPart& part : cut.parts) bytes += drawnBytes(*part.mesh);
  return bytes;
}

TEST(Instance, givesUpWhatStandsByBeforeWhatIsSeenAndThenWhatIsFinerThanWanted) {
  int without_fallbacks = 0, without_finer = 0;  // budgets at which each was given up
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

/// A camera whose cuts are looked at as blobs come.
class Watched : private Seeded {
 public:
  Watched(uint32_t seed, uint64_t drawn_budget_bytes)
      : Seeded(seed), instance_({.drawn_budget_bytes = drawn_budget_bytes}) {}

  /// Goes on from near the model to where less is wanted of what is there, and what was not seen before.
  static Watched steppingBack(uint32_t seed, uint64_t drawn_budget_bytes) {
    Watched camera(seed, drawn_budget_bytes);
    camera.see(closeView(), 4);
    camera.watch([](const Cut&) {});
    camera.see(kFront, 6);
    return camera;
  }

  void see(const View& view, float threshold_px) { instance_.setView(view, threshold_px); }

  /// Calls see(cut) each time that something has come, until all has.
  template <typename See>
  void watch(See&& see) {
    for (instance_.refine(model_);; instance_.refine(model_)) {
      see(*instance_.cut());
      if (instance_.requests().empty()) return;
      deliver(instance_.requests().front());
    }
  }

  /// How often the place that does so most becomes coarser meanwhile.
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

  const Instance& instance() const { return instance_; }

 private:
  static Parts::const_iterator partAt(const Parts& parts, NodeKey place) {
    for (int depth = place.depth(); depth >= 0; --depth)
      if (const auto found = parts.find(place.ancestorAt(depth)); found != parts.end()) return found;
    return parts.end();
  }

  Instance instance_;
};

TEST(Instance, doesNotTakeBackWhatItHasGivenUpEachTimeThatSomethingComes) {
  int most = 0;
  for (uint32_t seed = 1; seed < 7; ++seed) {
    auto unlimited = Watched::steppingBack(seed, std::numeric_limits<uint64_t>::max());
    unlimited.mostRises();
    const uint64_t liked = unlimited.instance().cut()->drawn_bytes;
    for (uint64_t budget = liked; budget < 5 * liked / 4; budget += liked / 16)
      most = std::max(most, Watched::steppingBack(seed, budget).mostRises());
  }
  EXPECT_LE(most, 2);
}

}  // namespace
}  // namespace lode::core
