// Refinement with budgets and hysteresis.

#include <algorithm>
#include <utility>
#include <vector>

#include "client/core/cache/mesh_cache.h"
#include "tests/support/seeds.h"
#include "tests/unit/core/scripted_client.h"

namespace lode::core {
namespace {

using namespace fixture;

class RefinerLimits : public testing::TestWithParam<uint32_t> {
 protected:
  SyntheticModel model_{{.seed = GetParam(), .empty_chance = GetParam() % 2 ? 0.1 : 0.0}};
  std::mt19937 random_{GetParam() * 7919};
};

INSTANTIATE_TEST_SUITE_P(Seeds, RefinerLimits, testing::Range(1u, 1 + lode::test::kSeeds));

TEST_P(RefinerLimits, convergesForEachViewInTurnIfTheBudgetHoldsPagesOfOne) {
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

TEST_P(RefinerLimits, requestsNoMorePagesAtOnceThanTheBudgetHolds) {
  const auto isPage = [](const Request& request) { return request.use.kind == BlobKind::kPage; };
  const auto pagesAskedFor = [&](uint64_t budget) {
    Scripted client(model_);
    while (true) {
      const std::vector<Request>& wanted =
          client.refineFor(closeView(), {.threshold_px = 1, .hierarchy_budget_bytes = budget}).wanted;
      const auto mesh = std::ranges::find_if_not(wanted, isPage);
      if (mesh == wanted.end()) return wanted.size();
      client.deliver(*mesh);
    }
  };
  const uint64_t first_page = Scripted(model_).hierarchy().bytes();
  const size_t all = pagesAskedFor(first_page + 1000 * pageBytesAtMost(1000));
  for (const size_t pages : {1, 2})
    EXPECT_EQ(pagesAskedFor(first_page + pages * pageBytesAtMost(1000)), std::min(pages, all));
}

TEST_P(RefinerLimits, isLimitedEvenIfTheBudgetLastStoppedAHeldNode) {
  constexpr float kHold = 0.25f;
  const uint64_t first_page = Scripted(model_).hierarchy().bytes();
  for (const View& view : {closeView(), farView()}) {
    const BruteForce errors(model_, view, 1);
    float largest_px = 0;  // largest error with the first page alone
    for (const auto& [key, node] : model_.nodes())
      if (node.child_page && boxMayBeVisible(toModelBox(node.box, SyntheticModel::lattice().step), view))
        largest_px = std::max(largest_px, errors.errorPx(key, 0));
    if (largest_px == 0) continue;
    Scripted client(model_);
    client.converge(view, {.threshold_px = largest_px / 16, .hysteresis_factor = kHold}, random_, kNoCheck);
    const RefineOptions coarser{
        .threshold_px = largest_px * 0.9f, .hysteresis_factor = kHold, .hierarchy_budget_bytes = first_page};
    EXPECT_TRUE(client.refineFor(view, coarser).limited);
  }
}

/// Reference implementation of a triangle budget: refines the visible part with the largest error, ties by
/// key, until one does not fit.
class LimitedBruteForce {
 public:
  LimitedBruteForce(const SyntheticModel& model, const View& view, float threshold_px, uint64_t triangles)
      : model_(model), view_(view), errors_(model, view, threshold_px) {
    parts_[kRootKey] = lastLod(kRootKey);
    while (true) {
      const auto worst = std::ranges::max_element(parts_, {}, [this](const auto& part) {
        return std::pair(isReplaceable(part.first) ? errorOf(part) : 0, ~part.first.value);
      });
      if (!isReplaceable(worst->first) || errorOf(*worst) <= threshold_px) return;
      const Parts before = parts_;
      replacePart(worst->first);
      if (trianglesOf(parts_) <= triangles) continue;
      parts_ = before;
      return;
    }
  }
  Parts parts() const {
    Parts shown = parts_;
    std::erase_if(shown, [this](const auto& part) { return trianglesOf({part}) == 0; });
    return shown;
  }

 private:
  uint32_t lastLod(NodeKey key) const {
    return static_cast<uint32_t>(model_.nodes().at(key).lods.size()) - 1;
  }
  float errorOf(const Parts::value_type& part) const { return errors_.errorPx(part.first, part.second); }
  bool isReplaceable(NodeKey key) const {
    const Node& node = model_.nodes().at(key);
    return (parts_.at(key) > 0 || !node.isLeaf()) && isVisible(key);
  }
  void replacePart(NodeKey key) {
    if (parts_[key] > 0) {
      --parts_[key];
      return;
    }
    const float replaced_px = errorOf({key, 0});
    parts_.erase(key);
    for (unsigned octant = 0; octant < 8; ++octant)
      if ((model_.nodes().at(key).child_mask >> octant & 1) != 0) begin(key.child(octant), replaced_px);
  }
  void begin(NodeKey key, float replaced_px) {
    uint32_t lod = lastLod(key);
    while (isVisible(key) && lod > 0 && errorOf({key, lod}) > replaced_px) --lod;
    parts_[key] = lod;
  }
  bool isVisible(NodeKey key) const {
    return boxMayBeVisible(toModelBox(model_.nodes().at(key).box, SyntheticModel::lattice().step), view_);
  }
  uint64_t trianglesOf(const Parts& parts) const {
    uint64_t triangles = 0;
    for (const auto& [key, lod] : parts) triangles += model_.nodes().at(key).lods[lod].triangles;
    return triangles;
  }

  const SyntheticModel& model_;
  const View view_;
  const BruteForce errors_;
  Parts parts_;
};

TEST_P(RefinerLimits, givesATriangleBudgetToTheLargestErrors) {
  for (const View& view : {closeView(), farView(), insideView()}) {
    const uint64_t liked = BruteForce(model_, view, 2).triangles();
    for (const uint64_t budget : {liked - 1, liked * 3 / 4, liked / 2, liked / 8}) {
      Scripted client(model_);
      client.converge(view, {.threshold_px = 2, .triangle_budget = budget}, random_, kNoCheck);
      EXPECT_TRUE(client.last().limited);
      EXPECT_EQ(partsOf(*client.last().cut), LimitedBruteForce(model_, view, 2, budget).parts()) << budget;
    }
  }
}

TEST_P(RefinerLimits, keepsTheThresholdOfPartsThatABudgetAllows) {
  Scripted unlimited(model_);
  unlimited.converge(closeView(), {.threshold_px = 1}, random_, kNoCheck);
  const RefineOptions options{.threshold_px = 1, .triangle_budget = unlimited.last().cut->triangles / 2};
  Scripted client(model_);
  client.converge(closeView(), options, random_, kNoCheck);
  for (const CutPart& part : client.last().cut->parts)
    EXPECT_TRUE(!part.visible || part.threshold_px == 1) << part.node.value;
}

TEST_P(RefinerLimits, showsNoVisiblePartWorseThanItsParent) {
  for (const View& view : {closeView(), insideView()}) {
    const BruteForce errors(model_, view, 2);
    for (const uint64_t budget :
         {errors.triangles() * 3 / 4, errors.triangles() / 2, errors.triangles() / 4}) {
      Scripted client(model_);
      client.converge(view, {.threshold_px = 2, .triangle_budget = budget}, random_, kNoCheck);
      for (const CutPart& part : client.last().cut->parts) {
        if (!part.visible || part.node == kRootKey) continue;
        EXPECT_LE(part.error_px, errors.errorPx(part.node.parent(), 0)) << part.node.value;
      }
    }
  }
}

TEST_P(RefinerLimits, staysWithinTheDrawnBudgetAndReportsTheLimit) {
  Scripted unlimited(model_), client(model_);
  unlimited.converge(closeView(), {.threshold_px = 1}, random_, kNoCheck);
  uint64_t liked_bytes = 0;
  for (const CutPart& part : unlimited.last().cut->parts) liked_bytes += drawnBytes(*part.mesh);
  EXPECT_EQ(unlimited.last().cut->drawn_bytes, liked_bytes);
  client.converge(closeView(), {.threshold_px = 1, .drawn_budget_bytes = liked_bytes - 1}, random_, kNoCheck);
  EXPECT_LT(client.last().cut->drawn_bytes, liked_bytes);
  EXPECT_GT(client.last().cut->drawn_bytes, liked_bytes / 2);
  EXPECT_TRUE(client.last().limited);
  EXPECT_TRUE(client.last().settled);
}

TEST(Refiner, countsPartsWithoutTrianglesInTheMemoryToo) {
  HierarchyPage page;
  const auto add = [&](NodeKey key, uint8_t children, float error_model) {
    Node node;
    node.key = key;
    node.box.add(glm::uvec3(0));
    node.box.add(glm::uvec3(1024));
    node.child_mask = children;
    node.lods = {{{}, 0, 0, 0, error_model, 0}};
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
    return refine({hierarchy, cache, 1, {}}, view, {.threshold_px = 2, .cut_budget_bytes = budget_bytes})
        .limited;
  };
  EXPECT_TRUE(limitedBy(8 * kPartBytes));
  EXPECT_FALSE(limitedBy(64 * kPartBytes));
}

/// Returns a view of the whole model, so that only the distance changes.
View viewFrom(double distance) { return lookingAt({512, 512, 512 + distance}, {512, 512, 512}); }

TEST(Refiner, keepsTheCutForATremblingCameraByHysteresis) {
  const auto partsAt = [](Scripted& client, double distance, float hysteresis_factor, std::mt19937& random) {
    client.converge(viewFrom(distance), {.threshold_px = 12, .hysteresis_factor = hysteresis_factor}, random,
                    kNoCheck);
    return partsOf(*client.last().cut);
  };
  size_t flickering = 0;  // models that flicker without hysteresis
  for (uint32_t seed = 1; seed < 13; ++seed) {
    const SyntheticModel model({.seed = seed});
    std::mt19937 random(seed);
    Scripted held(model), plain(model);
    partsAt(held, 3000, kHysteresisFactor, random);
    const Parts nearest = partsAt(held, 2700, kHysteresisFactor, random);
    for (const double distance : {3000., 2900., 2700., 2800., 3000.})
      EXPECT_EQ(partsAt(held, distance, kHysteresisFactor, random), nearest);
    flickering += partsAt(plain, 3000, 1, random) != partsAt(plain, 2700, 1, random);
  }
  EXPECT_GT(flickering, 0u);
}

TEST(Refiner, isNotLimitedByPartsThatOnlyHysteresisWouldKeep) {
  int held_back = 0;  // budgets that prevent what hysteresis would keep
  for (uint32_t seed = 1; seed < 13; ++seed) {
    const SyntheticModel model({.seed = seed});
    std::mt19937 random(seed);
    const RefineOptions plain{.threshold_px = 12},
        holding{.threshold_px = 12, .hysteresis_factor = kHysteresisFactor};
    Scripted fresh(model), held(model);
    fresh.converge(viewFrom(3000), plain, random, kNoCheck);
    held.converge(viewFrom(3000), plain, random, kNoCheck);
    held.converge(viewFrom(2700), holding, random, kNoCheck);
    RefineOptions tight = holding;
    tight.triangle_budget = fresh.last().cut->triangles;
    const Refinement& refinement = held.refineFor(viewFrom(3000), tight);
    EXPECT_FALSE(refinement.limited) << seed;
    EXPECT_TRUE(refinement.cut->converged) << seed;
    held.converge(viewFrom(2700), holding, random, kNoCheck);
    held_back += held.refineFor(viewFrom(3000), holding).cut->triangles > tight.triangle_budget;
  }
  EXPECT_GT(held_back, 0);
}

TEST(Refiner, coarsensOnceTheErrorFallsBelowTheHysteresis) {
  const SyntheticModel model({.seed = 3});
  std::mt19937 random(3);
  Scripted held(model), fresh(model);
  for (const double distance : {2800., 6000.})
    held.converge(viewFrom(distance), {.threshold_px = 4, .hysteresis_factor = kHysteresisFactor}, random,
                  kNoCheck);
  fresh.converge(viewFrom(6000), {.threshold_px = 4 * kHysteresisFactor}, random, kNoCheck);
  EXPECT_LE(held.last().cut->triangles, fresh.last().cut->triangles);
}

}  // namespace
}  // namespace lode::core
