#include "client/core/lod/refiner.h"

#include <algorithm>
#include <set>

#include "client/core/lod/cut.h"
#include "tests/support/seeds.h"
#include "tests/unit/core/refiner_on_seeds.h"

namespace lode::core {
namespace {

using namespace fixture;

INSTANTIATE_TEST_SUITE_P(Seeds, RefinerOnSeeds, testing::Range(1u, 1 + lode::test::kSeeds));

TEST_P(RefinerOnSeeds, convergesToTheCutThatBruteForceFinds) {
  for (const View& view : {closeView(), farView(), insideView()}) {
    for (const float threshold_px : {1.0f, 30.0f}) {
      Scripted client(model_);
      client.converge(view, {.threshold_px = threshold_px}, random_, kNoCheck);
      ASSERT_TRUE(client.last().cut);
      EXPECT_TRUE(client.last().cut->converged);
      EXPECT_TRUE(client.last().settled);
      EXPECT_EQ(partsOf(*client.last().cut), BruteForce(model_, view, threshold_px).parts());
    }
  }
}

TEST_P(RefinerOnSeeds, convergesToTheSameCutAfterOtherViews) {
  Scripted client(model_);
  for (const View& view : {farView(), insideView(), closeView(), farView()}) {
    client.converge(view, {.threshold_px = 5}, random_, kNoCheck);
    EXPECT_EQ(partsOf(*client.last().cut), BruteForce(model_, view, 5).parts());
  }
}

TEST_P(RefinerOnSeeds, givesPartsFromWhichTheErrorInThePictureFollows) {
  for (const View& view : {closeView(), farView(), insideView()}) {
    Scripted client(model_);
    client.converge(view, {.threshold_px = 5}, random_, kNoCheck);
    const Cut& cut = *client.last().cut;
    EXPECT_EQ(shownErrorPx(cut, shownParts(cut, view), view), cut.max_error_px);
  }
}

TEST_P(RefinerOnSeeds, givesWantedPartsTheThresholdEvenIfNoFinerLodExists) {
  bool is_above = false;
  for (const View& view : {closeView(), insideView()}) {
    Scripted client(model_);
    client.converge(view, {.threshold_px = 1}, random_, kNoCheck);
    for (const CutPart& part : client.last().cut->parts) {
      EXPECT_TRUE(!part.visible || part.threshold_px == 1) << part.node.value;
      is_above |= part.visible && part.error_px > 1;
    }
  }
  EXPECT_TRUE(is_above);
}

TEST_P(RefinerOnSeeds, givesACoarserStandInTheThresholdOfItsError) {
  const Parts wanted = BruteForce(model_, closeView(), 5).parts();
  bool has_coarser = false;
  const auto check = [&](const Refinement& now) {
    if (!now.cut) return;
    for (const CutPart& part : now.cut->parts) {
      const auto same = wanted.find(part.node);
      const bool is_wanted = same != wanted.end() && same->second == part.lod && part.visible;
      EXPECT_EQ(part.threshold_px, is_wanted ? 5 : std::max(5.0f, part.error_px)) << part.node.value;
      has_coarser |= !is_wanted;
    }
    for (const Fallback& fallback : now.cut->fallbacks)
      EXPECT_EQ(fallback.part.threshold_px, std::max(5.0f, fallback.part.error_px));
  };
  Scripted(model_).converge(closeView(), {.threshold_px = 5}, random_, check);
  EXPECT_TRUE(has_coarser);
}

TEST_P(RefinerOnSeeds, givesAFinerStandInASmallerThreshold) {
  Scripted client(model_);
  client.converge(closeView(), {.threshold_px = 1}, random_, kNoCheck);
  const Parts wanted = BruteForce(model_, closeView(), 20).parts();
  const Refinement& now = client.refineFor(closeView(), {.threshold_px = 20});
  bool has_finer = false;
  for (const CutPart& part : now.cut->parts) {
    const auto same = wanted.find(part.node);
    if (!part.visible || (same != wanted.end() && same->second == part.lod)) continue;
    EXPECT_EQ(part.threshold_px, std::min(20.0f, part.error_px));
    has_finer = true;
  }
  EXPECT_TRUE(has_finer);
}

TEST_P(RefinerOnSeeds, neverShowsAHoleOrAnOverlap) {
  Scripted client(model_);
  bool shown = false;
  const auto check = [&](const Refinement& now) {
    EXPECT_TRUE(now.cut || !shown);
    shown |= now.cut != nullptr;
    if (now.cut) expectComplete(model_, *now.cut, now.settled);
  };
  for (const View& view : {closeView(), insideView(), farView(), insideView()})
    client.converge(view, {.threshold_px = 4}, random_, check);
  EXPECT_TRUE(shown);
}

TEST_P(RefinerOnSeeds, neverShowsAHoleWhenTheCacheIsTooSmall) {
  Scripted unlimited(model_);
  unlimited.converge(closeView(), {.threshold_px = 4}, random_, kNoCheck);
  const uint64_t budget = unlimited.cache().bytes() / 3;
  Scripted client(model_, budget);
  bool was_limited = false;
  const auto check = [&](const Refinement& now) {
    was_limited |= now.limited;
    if (now.cut) expectComplete(model_, *now.cut, now.settled);
  };
  for (const View& view : {closeView(), insideView(), farView(), closeView()})
    client.converge(view, {.threshold_px = 4, .cut_budget_bytes = budget / 2}, random_, check);
  EXPECT_TRUE(was_limited);
}

TEST_P(RefinerOnSeeds, keepsResidentMeshesInUseWhileTheyAwaitTheirSiblings) {
  const Parts wanted = BruteForce(model_, closeView(), 4).parts();
  Scripted client(model_);
  std::vector<MeshKey> there;
  bool one_waits = false;
  while (!client.refineFor(closeView(), {.threshold_px = 4}).wanted.empty()) {
    const Refinement& now = client.last();
    for (const MeshKey& key : there) {
      EXPECT_EQ(std::ranges::count(now.in_use, key), 1) << key.node.value;
      one_waits |= !partsOf(*now.cut).contains(key.node);
    }
    const Request next = now.wanted[random_() % now.wanted.size()];
    client.deliver(next);
    const auto part = wanted.find(next.use.mesh.node);
    if (next.use.kind == BlobKind::kMesh && part != wanted.end() && part->second == next.use.mesh.lod)
      there.push_back(next.use.mesh);
  }
  EXPECT_TRUE(one_waits);
}

TEST_P(RefinerOnSeeds, keepsAFinerMeshUntilTheCoarserArrives) {
  const View near = lookingAt({1500, 1600, 4000}, {512, 512, 512});
  const View far = lookingAt({6000, 6400, 16000}, {512, 512, 512});
  Scripted client(model_);
  client.converge(near, {.threshold_px = 2}, random_, kNoCheck);
  for (const CutPart& part : client.last().cut->parts) ASSERT_TRUE(part.visible);
  const Refinement& now = client.refineFor(far, {.threshold_px = 2});
  EXPECT_FALSE(now.wanted.empty());
  expectComplete(model_, *now.cut, now.settled);
  for (const CutPart& part : now.cut->parts)
    EXPECT_TRUE(part.error_px <= 2 || (part.lod == 0 && model_.nodes().at(part.node).isLeaf()));
}

TEST_P(RefinerOnSeeds, aLowerThresholdNeverGivesLessTriangles) {
  uint64_t before = 0;
  for (const float threshold_px : {64.0f, 16.0f, 4.0f, 1.0f}) {
    Scripted client(model_);
    client.converge(closeView(), {.threshold_px = threshold_px}, random_, kNoCheck);
    EXPECT_GE(client.last().cut->triangles, before);
    before = client.last().cut->triangles;
  }
}

TEST_P(RefinerOnSeeds, staysWithinATriangleBudgetAndReportsTheLimit) {
  Scripted unlimited(model_);
  unlimited.converge(closeView(), {.threshold_px = 1}, random_, kNoCheck);
  const uint64_t budget = unlimited.last().cut->triangles / 2;
  Scripted client(model_);
  client.converge(closeView(), {.threshold_px = 1, .triangle_budget = budget}, random_, kNoCheck);
  EXPECT_LE(client.last().cut->triangles, budget);
  EXPECT_TRUE(client.last().limited);
  EXPECT_TRUE(client.last().settled);
  EXPECT_FALSE(client.last().cut->converged);
}

TEST_P(RefinerOnSeeds, staysWithinAMemoryBudgetAndReportsTheLimit) {
  Scripted unlimited(model_);
  unlimited.converge(closeView(), {.threshold_px = 1}, random_, kNoCheck);
  uint64_t all = 0;
  for (const CutPart& part : unlimited.last().cut->parts) all += meshBytes(*part.mesh);
  Scripted client(model_);
  client.converge(closeView(), {.threshold_px = 1, .cut_budget_bytes = all - 1}, random_, kNoCheck);
  uint64_t held = 0;
  for (const CutPart& part : client.last().cut->parts) held += meshBytes(*part.mesh);
  EXPECT_LT(held, all);
  EXPECT_TRUE(client.last().limited);
  EXPECT_FALSE(client.last().cut->converged);
}

TEST_P(RefinerOnSeeds, requestsNoPageBeyondTheHierarchyBudget) {
  Scripted unlimited(model_);
  unlimited.converge(closeView(), {.threshold_px = 1}, random_, kNoCheck);
  const uint64_t known_bytes = unlimited.hierarchy().bytes();
  Scripted client(model_);
  const uint64_t budget = client.hierarchy().bytes();
  if (known_bytes == budget) GTEST_SKIP() << "all of it is in the first page";
  client.converge(closeView(), {.threshold_px = 1, .hierarchy_budget_bytes = budget}, random_, kNoCheck);
  EXPECT_EQ(client.hierarchy().bytes(), budget);
  EXPECT_TRUE(client.last().settled);
  EXPECT_TRUE(client.last().limited);
  EXPECT_FALSE(client.last().cut->converged);
}

TEST_P(RefinerOnSeeds, requestsAtMostATwentiethMoreThanTheConvergedCut) {
  Scripted client(model_);
  client.converge(closeView(), {.threshold_px = 1}, random_, kNoCheck);
  uint64_t needed = model_.nodes().at(kRootKey).lods.back().payload.bytes;
  for (const auto& [key, lod] : partsOf(*client.last().cut))
    needed += model_.nodes().at(key).lods[lod].payload.bytes;
  EXPECT_LE(client.deliveredPayloadBytes(), needed * 21 / 20);
}

/// Returns the part of a cut at a node or above it, if any.
const CutPart* partAt(const Cut& cut, NodeKey node) {
  for (const CutPart& part : cut.parts)
    if (part.node.contains(node)) return &part;
  return nullptr;
}

TEST_P(RefinerOnSeeds, requestsTheLargestErrorInThePictureFirst) {
  constexpr float kThresholdPx = 2;
  const Parts right = BruteForce(model_, closeView(), kThresholdPx).parts();
  size_t compared = 0;
  const auto check = [&](const Refinement& now) {
    const auto first = std::ranges::find_if(
        now.wanted, [](const Request& request) { return request.use.kind == BlobKind::kMesh; });
    if (!now.cut || first == now.wanted.end() || first->request_class != proto::RequestClass::kVisible)
      return;
    float largest_px = 0;
    for (const CutPart& part : now.cut->parts) {
      const auto same = right.find(part.node);
      const bool is_right = same != right.end() && same->second == part.lod;
      const bool waits_for_page = std::ranges::any_of(now.wanted, [&](const Request& request) {
        return request.use.kind == BlobKind::kPage && part.node.contains(request.use.mesh.node);
      });
      if (part.visible && !is_right && !waits_for_page) largest_px = std::max(largest_px, part.error_px);
    }
    if (largest_px <= kThresholdPx) return;  // only finer parts than necessary are left
    const CutPart* const replaced = partAt(*now.cut, first->use.mesh.node);
    ASSERT_NE(replaced, nullptr);
    EXPECT_EQ(replaced->error_px, largest_px);
    ++compared;
  };
  Scripted(model_).converge(closeView(), {.threshold_px = kThresholdPx}, random_, check);
  EXPECT_GT(compared, 10u);
}

TEST(Refiner, requestsTheRootFirstAndShowsNothingBeforeIt) {
  const SyntheticModel model({.seed = 3});
  Scripted client(model);
  const Refinement& first = client.refineFor(closeView(), {.threshold_px = 2});
  EXPECT_FALSE(first.cut);
  ASSERT_EQ(first.wanted.size(), 1u);
  EXPECT_EQ(first.wanted[0].use.mesh, (MeshKey{kRootKey, 3}));
}

TEST(Refiner, showsACompleteStepBeforeMostDetailArrives) {
  const SyntheticModel model({.seed = 5, .split_chance = 1});
  const RefineOptions options{.threshold_px = 1};
  Scripted whole(model);
  std::mt19937 random(1);
  whole.converge(closeView(), options, random, kNoCheck);

  Scripted client(model);
  uint64_t triangles_at_half = 0;
  while (!client.refineFor(closeView(), options).wanted.empty()) {
    if (client.last().cut && client.deliveredPayloadBytes() < whole.deliveredPayloadBytes() / 2)
      triangles_at_half = client.last().cut->triangles;
    client.deliver(client.last().wanted.front());
  }
  EXPECT_GT(triangles_at_half, 4 * model.nodes().at(kRootKey).lods.back().triangles);
}

TEST(Refiner, keepsPartsOutsideTheViewAtTheirCoarsestLod) {
  const SyntheticModel model({.seed = 4});
  Scripted client(model);
  std::mt19937 random(2);
  client.converge(insideView(), {.threshold_px = 1}, random, kNoCheck);
  size_t outside = 0;
  for (const CutPart& part : client.last().cut->parts) {
    if (part.visible) continue;
    ++outside;
    EXPECT_EQ(part.lod + 1, model.nodes().at(part.node).lods.size());
  }
  EXPECT_GT(outside, 0u);
}

TEST_P(RefinerOnSeeds, countsTheErrorOfVisiblePartsOnly) {
  Scripted client(model_);
  client.converge(insideView(), {.threshold_px = 1}, random_, kNoCheck);
  float seen_px = 0;  // in most of these models parts outside the view have larger errors
  for (const CutPart& part : client.last().cut->parts)
    if (part.visible) seen_px = std::max(seen_px, part.error_px);
  EXPECT_EQ(client.last().cut->max_error_px, seen_px);
}

TEST_P(RefinerOnSeeds, countsVisiblePartsExceptFinestLeavesAsRefinable) {
  Scripted client(model_);
  bool is_less = false;
  for (const View& view : {farView(), insideView(), closeView()}) {
    client.converge(view, {.threshold_px = 1}, random_, [&](const Refinement& refined) {
      if (!refined.cut) return;
      float refinable_px = 0;
      for (const CutPart& part : refined.cut->parts)
        if (part.visible && (part.lod > 0 || !model_.nodes().at(part.node).isLeaf()))
          refinable_px = std::max(refinable_px, part.error_px);
      EXPECT_EQ(refined.cut->refinable_px, refinable_px);
    });
    EXPECT_LE(client.last().cut->refinable_px, 1);
    is_less |= client.last().cut->refinable_px < client.last().cut->max_error_px;
  }
  EXPECT_TRUE(is_less);
}

TEST_P(RefinerOnSeeds, listsAllResidentMeshesAboveTheCutAsAncestors) {
  Scripted client(model_);
  client.converge(closeView(), {.threshold_px = 2}, random_, kNoCheck);
  const Parts parts = partsOf(*client.last().cut);
  std::set<MeshKey> above;
  for (const auto& [key, node] : model_.nodes())
    for (const auto& [part, part_lod] : parts)
      for (uint32_t lod = 0; lod < node.lods.size(); ++lod)
        if (part != key && key.contains(part) && client.cache().lodsOf(key).has(lod))
          above.insert({key, lod});
  const auto& named = client.last().ancestors;
  EXPECT_FALSE(above.empty());
  EXPECT_EQ(std::set<MeshKey>(named.begin(), named.end()), above);
}

TEST(Refiner, refinesOnTheAppearanceErrorToo) {
  HierarchyPage page;
  Node root;
  root.key = kRootKey;
  root.box.add(glm::uvec3(0));
  root.box.add(glm::uvec3(1024));
  root.lods = {{{1, 10, {}}, 100, 60, 0, 0, 0}, {{2, 10, {}}, 10, 9, 0, 0, 1}};
  page.nodes = {root};
  Hierarchy hierarchy(1);
  hierarchy.addRootPage(page);
  MeshCache cache(1u << 20);
  const View view = lookingAt({512, 512, 2000}, {512, 512, 0});
  EXPECT_EQ(refine({hierarchy, cache, 1, {}}, view, {.threshold_px = 2}).wanted[0].use.mesh.lod, 1u);
  cache.insert({kRootKey, 1}, std::make_shared<const Mesh>());
  EXPECT_TRUE(refine({hierarchy, cache, 1, {}}, view, {.threshold_px = 2}).wanted.empty());
  const Refinement sharp = refine({hierarchy, cache, 1, {}}, view, {.threshold_px = 0.1f});
  ASSERT_EQ(sharp.wanted.size(), 1u);
  EXPECT_EQ(sharp.wanted[0].use.mesh.lod, 0u);
}

TEST(Refiner, publishesPartsDepthFirstWithTheirMeshes) {
  const auto cell = [](NodeKey node) {
    return node.value << 3 * (kMaxDepth - node.depth());
  };  // first cell of a node
  const SyntheticModel model({.seed = 6, .empty_chance = 0.2});
  Scripted client(model);
  std::mt19937 random(3);
  client.converge(closeView(), {.threshold_px = 1}, random, [&](const Refinement& now) {
    if (!now.cut) return;
    uint64_t triangles = 0;
    for (size_t i = 0; i < now.cut->parts.size(); ++i) {
      ASSERT_TRUE(now.cut->parts[i].mesh);
      triangles += now.cut->parts[i].mesh->triangles.size();
      EXPECT_TRUE(i == 0 || cell(now.cut->parts[i - 1].node) < cell(now.cut->parts[i].node));
    }
    EXPECT_EQ(triangles, now.cut->triangles);
  });
}

}  // namespace
}  // namespace lode::core
