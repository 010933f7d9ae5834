#include "client/core/prefetcher.h"

#include "tests/unit/core/scripted_client.h"

namespace lode::core {
namespace {

using namespace fixture;
using std::chrono::milliseconds;

constexpr RefineOptions kOptions{.threshold_px = 1};

/// A model of which the coarsest rung alone is there.
Model coarseModel(const SyntheticModel& tree, uint64_t memory_budget_bytes) {
  ModelSummary summary;
  summary.lattice = SyntheticModel::lattice();
  summary.attributes = SyntheticModel::attributes();
  summary.box = tree.nodes().at(kRootKey).box;
  summary.nodes = tree.nodes().size();
  Model model(summary, memory_budget_bytes);
  model.take({}, {BlobKind::kRootPage, {kRootKey, 0}}, encodePage(tree.rootPage()));
  const MeshKey coarsest = model.firstWish().value().use.mesh;
  model.meshes().insert(coarsest, tree.mesh(coarsest));
  return model;
}

/// What is asked for ahead of a camera that goes on towards the model.
std::vector<Wish> askedAhead(const Model& model) {
  Prefetcher prefetcher;
  TimePoint now{};
  for (int step = 0; step < 10; ++step, now += milliseconds(25))
    prefetcher.see(lookingAt({512, 512, 3000 - 20. * step}, {512, 512, 512}), now);
  prefetcher.lookAhead(model, kOptions, now);
  return prefetcher.wishes();
}

TEST(Prefetcher, asksForWhatAMovingCameraWillNeed) {
  const SyntheticModel tree({.seed = 3});
  EXPECT_FALSE(askedAhead(coarseModel(tree, 1ull << 30)).empty());
}

TEST(Prefetcher, leavesAShareOfTheMemoryToWhatIsSeen) {
  const SyntheticModel tree({.seed = 3});
  const Model roomy = coarseModel(tree, 1ull << 30);
  // Of the whole three quarters are for meshes, and three quarters of these for what is asked for ahead.
  const uint64_t half_full_bytes = roomy.meshes().bytes() * 16 / 9;
  EXPECT_TRUE(askedAhead(coarseModel(tree, half_full_bytes - 16)).empty());
  EXPECT_FALSE(askedAhead(coarseModel(tree, half_full_bytes + 64)).empty());
}

}  // namespace
}  // namespace lode::core
