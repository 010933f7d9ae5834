// Parts that a refinement leaves out outside the view, and their fallbacks.

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "client/core/cache/mesh_cache.h"
#include "client/core/lod/cut.h"
#include "client/core/lod/refiner.h"
#include "tests/unit/core/refiner_on_seeds.h"

namespace lode::core {
namespace {

using namespace fixture;

/// Delivers the best requests of the visible class until none is left.
void deliverWhatIsSeen(Scripted& client, const View& view, float threshold_px) {
  for (int round = 0; round < 20000; ++round) {
    const Refinement& now = client.refineFor(view, {.threshold_px = threshold_px});
    if (now.wanted.empty() || now.wanted.front().request_class != proto::RequestClass::kVisible) return;
    client.deliver(now.wanted.front());
  }
  FAIL() << "requests without end";
}

TEST_P(RefinerOnSeeds, convergesWithoutPartsFarOutsideTheView) {
  Scripted client(model_);
  deliverWhatIsSeen(client, insideView(), 1);
  ASSERT_TRUE(client.last().cut);
  EXPECT_TRUE(client.last().cut->converged);
  const Parts shown = partsOf(*client.last().cut);
  const Parts wanted = BruteForce(model_, insideView(), 1).parts();
  for (const auto& [key, lod] : wanted) {
    if (!isNear(model_, key, insideView())) continue;
    EXPECT_EQ(shown.at(key), lod) << key.value;
  }
  for (const Request& request : client.last().wanted)
    EXPECT_FALSE(isNear(model_, request.use.mesh.node, insideView()));
}

TEST_P(RefinerOnSeeds, convergesWithoutStandInsFarOutsideTheView) {
  Scripted client(model_);
  client.converge(farView(), {.threshold_px = 5}, random_, kNoCheck);
  deliverWhatIsSeen(client, insideView(), 1);
  EXPECT_TRUE(client.last().cut->converged);
}

TEST_P(RefinerOnSeeds, showsAWholePictureToACameraThatTurnsEarly) {
  Scripted client(model_);
  deliverWhatIsSeen(client, insideView(), 1);
  View turned = insideView();
  std::swap(turned.forward, turned.up);
  for (const View& view : {turned, farView(), insideView()}) {
    const Refinement& now = client.refineFor(view, {.threshold_px = 1});
    ASSERT_TRUE(now.cut);
    expectComplete(model_, *now.cut, now.settled);
  }
}

/// Returns the finest resident LOD of the nearest resident ancestor.
std::optional<MeshKey> nearestAbove(const MeshCache& cache, NodeKey place) {
  while (place != kRootKey) {
    place = place.parent();
    const MeshCache::Lods& lods = cache.lodsOf(place);
    for (uint32_t lod = 0; lod < kMaxLods; ++lod)
      if (lods.has(lod)) return MeshKey{place, lod};
  }
  return std::nullopt;
}

TEST(Refiner, leavesOutNodesOfMostModelsInTheFallbackTests) {
  int models = 0;
  for (uint32_t seed = 1; seed < 13; ++seed) {
    const SyntheticModel model({.seed = seed, .empty_chance = seed % 2 ? 0.1 : 0.0});
    std::mt19937 random(seed * 7919);
    Scripted client(model);
    client.converge(farView(), {.threshold_px = 5}, random, kNoCheck);
    deliverWhatIsSeen(client, insideView(), 1);
    models += client.last().cut->fallbacks.size() > 1;
  }
  EXPECT_GE(models, 8);
}

TEST_P(RefinerOnSeeds, holdsTheNearestResidentAncestorOfEachLeftOutNode) {
  Scripted client(model_);
  client.converge(farView(), {.threshold_px = 5}, random_, kNoCheck);
  deliverWhatIsSeen(client, insideView(), 1);
  const Refinement& now = client.last();
  size_t held_for = 0;
  for (const Fallback& fallback : now.cut->fallbacks) {
    const MeshKey held{fallback.part.node, fallback.part.lod};
    EXPECT_EQ(fallback.part.mesh, client.cache().find(held));
    EXPECT_EQ(std::ranges::count(now.in_use, held), 1);
    EXPECT_LT(fallback.first_left_out, fallback.end_left_out);
    for (uint32_t place = fallback.first_left_out; place < fallback.end_left_out; ++place, ++held_for)
      EXPECT_EQ(nearestAbove(client.cache(), now.cut->left_out[place].node), held);
    for (uint32_t part = 0; part < now.cut->parts.size(); ++part)
      EXPECT_EQ(held.node.contains(now.cut->parts[part].node),
                part >= fallback.first_part && part < fallback.end_part);
  }
  EXPECT_EQ(held_for, now.cut->left_out.size());
}

TEST_P(RefinerOnSeeds, holdsFallbacksWithinTheirMemoryOrTheRootsCoarsestLod) {
  Scripted client(model_);
  client.converge(farView(), {.threshold_px = 5}, random_, kNoCheck);
  deliverWhatIsSeen(client, insideView(), 1);
  const auto bytesOf = [](const Cut& cut, const auto& bytesOfMesh) {
    uint64_t bytes = 0;
    for (const Fallback& fallback : cut.fallbacks) bytes += bytesOfMesh(*fallback.part.mesh);
    return bytes;
  };
  const auto residentBytes = [](const Mesh& mesh) { return meshBytes(mesh); };
  const auto copiedBytes = [](const Mesh& mesh) { return drawnBytes(mesh); };
  const MeshKey coarsest{kRootKey, static_cast<uint32_t>(model_.nodes().at(kRootKey).lods.size()) - 1};
  const std::shared_ptr<const Mesh> last = model_.mesh(coarsest);
  const auto cutWith = [&](const RefineOptions& options) {
    const std::shared_ptr<const Cut> cut = client.refineFor(insideView(), options).cut;
    EXPECT_FALSE(cut->left_out.empty());
    EXPECT_EQ(countHoles(*cut, shownParts(*cut, farView()), farView()), 0u);
    return cut;
  };
  const std::shared_ptr<const Cut> all = client.last().cut;
  for (uint64_t budget = bytesOf(*all, residentBytes); budget > 0; budget /= 2)
    EXPECT_LE(bytesOf(*cutWith({.threshold_px = 1, .fallback_budget_bytes = budget}), residentBytes),
              budget + meshBytes(*last));
  for (uint64_t budget = bytesOf(*all, copiedBytes); budget > 0; budget /= 2)
    EXPECT_LE(bytesOf(*cutWith({.threshold_px = 1, .fallback_drawn_budget_bytes = budget}), copiedBytes),
              budget + drawnBytes(*last));
  const Cut& cut = *client.refineFor(insideView(), {.threshold_px = 1, .fallback_budget_bytes = 0}).cut;
  ASSERT_EQ(cut.fallbacks.size(), cut.left_out.empty() ? 0u : 1u);
  if (cut.left_out.empty()) return;
  const Fallback& root = cut.fallbacks.front();
  EXPECT_EQ((MeshKey{root.part.node, root.part.lod}), coarsest);
  EXPECT_EQ(root.end_left_out - root.first_left_out, cut.left_out.size());
  EXPECT_EQ(root.end_part - root.first_part, cut.parts.size());
}

TEST_P(RefinerOnSeeds, leavesNothingOutWithoutAFallback) {
  const Hierarchy hierarchy = model_.hierarchy();
  MeshCache cache(1ull << 40);  // without the root's meshes
  std::vector<NodeKey> missing;
  for (const auto& [key, node] : model_.nodes())
    if (key != kRootKey) missing.push_back(key);
  std::shuffle(missing.begin(), missing.end(), random_);
  bool shown = false;
  for (; !missing.empty(); missing.pop_back()) {
    cache.insert({missing.back(), 0}, model_.mesh({missing.back(), 0}));
    const Refinement now =
        refine({hierarchy, cache, SyntheticModel::lattice().step, SyntheticModel::attributes()}, insideView(),
               {.threshold_px = 1});
    shown |= now.cut != nullptr;
    if (now.cut) expectComplete(model_, *now.cut, true);
  }
  EXPECT_TRUE(shown);
}

}  // namespace
}  // namespace lode::core
