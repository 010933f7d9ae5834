
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "client/core/cache/mesh_cache.h"
#include "client/core/lod/cut.h"
#include "tests/unit/core/seeded_model.h"

namespace lode::core {
namespace {

using namespace fixture;

const View kNear = closeView(), kFar = farView(), kAside = lookingAt({2600, 512, 512}, {512, 512, 512}),
           kAway = lookingAt({512, 512, 2500}, {512, 512, 9000});

/// A model with several instances.
class Standing : private Seeded {
 public:
  explicit Standing(uint32_t seed, uint64_t memory_budget_bytes = 1ull << 40,
                    const RefineOptions& options = {})
      : Seeded(seed, memory_budget_bytes), group_(options) {}

  void see(const std::vector<View>& views, float threshold_px = 1) {
    group_.setViews(views, threshold_px);
    group_.refine(model_);
  }
  /// Delivers all blobs and calls watch() after each. @return the number of blobs.
  template <typename Watch>
  int deliverAll(Watch&& watch) {
    constexpr int kTooMany = 5000;
    int count = 0;
    for (; !group_.requests().empty() && count < kTooMany; ++count) {
      deliver(group_.requests().front());
      group_.refine(model_);
      watch();
    }
    EXPECT_LT(count, kTooMany);
    return count;
  }
  int deliverAll() {
    return deliverAll([] {});
  }

  void give(uint64_t memory_budget_bytes, uint64_t drawn_budget_bytes) {
    model_.setMemoryBudget(memory_budget_bytes);
    group_.setDrawnBudget(drawn_budget_bytes);
    group_.refine(model_);
  }

  const ViewGroup& group() const { return group_; }
  const Cut& cut(size_t view) const { return *group_.viewCuts()->cuts[view]; }
  const Cut& all() const { return *group_.cut(); }
  uint64_t residentBytes() const { return model_.meshes().bytes(); }
  uint64_t budgetBytes() const { return model_.meshes().budgetBytes(); }
  Parts wanted(const View& view, float threshold_px) const {
    return BruteForce(tree_, view, threshold_px).parts();
  }

 private:
  ViewGroup group_;
};

class ViewsOfAGroup : public testing::TestWithParam<uint32_t> {};
INSTANTIATE_TEST_SUITE_P(Seeds, ViewsOfAGroup, testing::Range(1u, 7u));

TEST_P(ViewsOfAGroup, convergeToTheSameCutsAsAlone) {
  Standing model(GetParam());
  model.see({kNear, kFar, kAside});
  model.deliverAll();
  EXPECT_EQ(partsOf(model.cut(0)), model.wanted(kNear, 1));
  EXPECT_EQ(partsOf(model.cut(1)), model.wanted(kFar, 1));
  EXPECT_EQ(partsOf(model.cut(2)), model.wanted(kAside, 1));
  EXPECT_TRUE(model.group().settled());
  EXPECT_TRUE(model.all().converged);
}

std::map<BlobUse, Request> byUse(const std::vector<Request>& requests) {
  std::map<BlobUse, Request> found;
  for (const Request& request : requests) EXPECT_TRUE(found.emplace(request.use, request).second);
  return found;
}

TEST_P(ViewsOfAGroup, requestAMeshOnceWithItsHighestPriority) {
  Standing both(GetParam()), near(GetParam()), aside(GetParam());
  both.see({kAside, kNear});
  near.see({kNear, kNear});  // two views disable the occlusion estimate
  aside.see({kAside, kAside});
  const auto of_near = byUse(near.group().requests()), of_aside = byUse(aside.group().requests());
  const auto merged = byUse(both.group().requests());
  std::set<BlobUse> uses;
  for (const auto* requests : {&of_near, &of_aside})
    for (const auto& [use, request] : *requests) uses.insert(use);
  ASSERT_EQ(merged.size(), uses.size());
  ASSERT_LT(uses.size(), of_near.size() + of_aside.size()) << "nothing is shared";
  for (const auto& [use, request] : merged) {
    for (const auto* requests : {&of_near, &of_aside}) {
      const auto one = requests->find(use);
      if (one == requests->end()) continue;
      EXPECT_LE(request.request_class, one->second.request_class);
      if (request.request_class == one->second.request_class) {
        EXPECT_GE(request.priority_px, one->second.priority_px);
      }
    }
  }
  EXPECT_TRUE(std::ranges::is_sorted(both.group().requests(), [](const Request& a, const Request& b) {
    return a.request_class != b.request_class ? a.request_class < b.request_class
                                              : a.priority_px > b.priority_px;
  }));
}

TEST_P(ViewsOfAGroup, costNothingWhereTheCameraDoesNotSeeThem) {
  Standing one(GetParam()), two(GetParam());
  one.see({kFar, kFar});
  two.see({kFar, kAway});
  EXPECT_EQ(byUse(two.group().requests()).size(), byUse(one.group().requests()).size());
  const int came = one.deliverAll();
  EXPECT_EQ(two.deliverAll(), came);
  EXPECT_EQ(two.residentBytes(), one.residentBytes());
  EXPECT_EQ(two.cut(1).parts.size(), 1u) << "the root stands by";
}

TEST_P(ViewsOfAGroup, shareTheirDrawnMeshes) {
  Standing model(GetParam());
  model.see({kNear, kNear, kFar});
  model.deliverAll();
  std::set<const Mesh*> drawn, of_cuts;
  for (const CutPart& part : model.all().parts) EXPECT_TRUE(drawn.insert(part.mesh.get()).second);
  for (size_t view = 0; view < 3; ++view)
    for (size_t number = 0; number < partCount(model.cut(view)); ++number)
      of_cuts.insert(partOf(model.cut(view), number).mesh.get());
  EXPECT_EQ(drawn, of_cuts);
  EXPECT_EQ(model.cut(0).triangles, model.cut(1).triangles);
  EXPECT_EQ(model.all().triangles, 2 * model.cut(0).triangles + model.cut(2).triangles);
}

/// Returns the threshold at which every view has the cut that it would have alone, if any.
std::optional<float> commonThreshold(const Standing& model, const std::vector<View>& views) {
  for (int step = 0; step < 80; ++step) {
    const float threshold_px = std::exp2(static_cast<float>(step) / 4);
    bool is_common = true;
    for (size_t view = 0; view < views.size(); ++view)
      is_common = is_common && partsOf(model.cut(view)) == model.wanted(views[view], threshold_px);
    if (is_common) return threshold_px;
  }
  return std::nullopt;
}

TEST_P(ViewsOfAGroup, areHeldToACommonErrorIfTheDrawnBudgetIsShort) {
  const std::vector<View> views{kNear, kAside, kFar};
  Standing unlimited(GetParam());
  unlimited.see(views);
  unlimited.deliverAll();
  const uint64_t budget_bytes = unlimited.all().drawn_bytes / 2;
  Standing model(GetParam(), 1ull << 40, {.drawn_budget_bytes = budget_bytes});
  model.see(views);
  model.deliverAll([&] { EXPECT_LE(model.all().drawn_bytes, budget_bytes); });
  EXPECT_TRUE(model.group().limited());
  EXPECT_TRUE(model.group().settled());
  EXPECT_FALSE(model.all().converged);
  const std::optional<float> threshold_px = commonThreshold(model, views);
  ASSERT_TRUE(threshold_px);
  EXPECT_GT(*threshold_px, 1);
}

TEST_P(ViewsOfAGroup, keepWithinTheMemoryOfTheModelTogether) {
  const std::vector<View> views{kNear, kAside, insideView()};
  Standing unlimited(GetParam());
  unlimited.see(views);
  unlimited.deliverAll();
  Standing model(GetParam(), unlimited.residentBytes());
  model.see(views);
  model.deliverAll([&] { EXPECT_LE(model.residentBytes(), model.budgetBytes()); });
  EXPECT_TRUE(model.group().limited());
  EXPECT_TRUE(commonThreshold(model, views));
}

TEST_P(ViewsOfAGroup, becomeAsFineAsWantedOnceAnotherViewIsGone) {
  Standing unlimited(GetParam());
  unlimited.see({kFar, kFar});
  unlimited.deliverAll();
  Standing model(GetParam(), 1ull << 40, {.drawn_budget_bytes = 2 * unlimited.all().drawn_bytes});
  model.see({kFar, kNear, insideView()});
  model.deliverAll();
  ASSERT_TRUE(model.group().limited());
  model.see({kFar, kAway, kAway});
  model.deliverAll();
  EXPECT_TRUE(model.all().converged);
  EXPECT_EQ(partsOf(model.cut(0)), model.wanted(kFar, 1));
}

TEST_P(ViewsOfAGroup, reportTheMemoryTheyWantEvenIfTheyGetLess) {
  const RefineOptions counted{.shares_memory = true};
  Standing unlimited(GetParam(), 1ull << 40, counted);
  unlimited.see({kNear});
  unlimited.deliverAll();
  uint64_t wanted_bytes = 0;
  for (const CutPart& part : unlimited.all().parts) wanted_bytes += meshBytes(*part.mesh) + kPartBytes;
  EXPECT_EQ(unlimited.group().wantedBytes(), wanted_bytes);
  Standing model(GetParam(), 1ull << 40, counted);
  model.give(1ull << 40, unlimited.all().drawn_bytes / 2);
  model.see({kNear});
  model.deliverAll();
  EXPECT_TRUE(model.group().limited());
  EXPECT_GT(model.group().wantedBytes(), wanted_bytes / 3);
  EXPECT_LT(model.group().wantedBytes(), wanted_bytes * 3);
}

TEST_P(ViewsOfAGroup, becomeCoarserWithLessMemoryAndAsFineAgainWithMore) {
  const std::vector<View> views{kNear, kAside};
  Standing model(GetParam(), 1ull << 40);
  model.see(views);
  model.deliverAll();
  const uint64_t resident_bytes = model.residentBytes(), drawn_bytes = model.all().drawn_bytes;
  model.give(resident_bytes, drawn_bytes / 2);
  EXPECT_LT(model.budgetBytes(), resident_bytes);
  EXPECT_LE(model.residentBytes(), model.budgetBytes());
  EXPECT_LE(model.all().drawn_bytes, drawn_bytes / 2);
  model.deliverAll();
  EXPECT_TRUE(model.group().limited());
  EXPECT_TRUE(commonThreshold(model, views));
  model.give(1ull << 40, 1ull << 40);
  model.deliverAll();
  EXPECT_TRUE(model.all().converged);
  EXPECT_EQ(partsOf(model.cut(0)), model.wanted(kNear, 1));
}

}  // namespace
}  // namespace lode::core
