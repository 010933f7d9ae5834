#include "client/core/lod/prefetcher.h"

#include <algorithm>
#include <functional>
#include <memory>
#include <set>
#include <vector>

#include "tests/unit/core/scripted_client.h"

namespace lode::core {
namespace {

using namespace fixture;
using std::chrono::milliseconds;

constexpr RefineOptions kOptions{.threshold_px = 1};

/// A model with only the coarsest LOD resident.
Model coarseModel(const SyntheticModel& tree, uint64_t memory_budget_bytes) {
  ModelSummary summary;
  summary.lattice = SyntheticModel::lattice();
  summary.attributes = SyntheticModel::attributes();
  summary.box = tree.nodes().at(kRootKey).box;
  summary.nodes = tree.nodes().size();
  Model model(summary, memory_budget_bytes);
  model.take({}, {BlobKind::kRootPage, {kRootKey, 0}}, encodePage(tree.rootPage()));
  const MeshKey coarsest = model.firstRequest().value().use.mesh;
  model.meshes().insert(coarsest, tree.mesh(coarsest));
  return model;
}

/// Returns the view of a camera that moves forwards.
using Flight = std::function<View(int step)>;

View towardsTheModel(int step) { return lookingAt({512, 512, 3000 - 20. * step}, {512, 512, 512}); }
View standing(int) { return lookingAt({512, 512, 3000}, {512, 512, 512}); }
View beside(int step) { return lookingAt({512 + 1500, 512, 2200 - 20. * step}, {512 + 1500, 512, 512}); }

/// Returns the prefetch requests of a moving camera for all instances of a model.
std::vector<Request> askedAhead(const Model& model, const std::vector<Flight>& places = {towardsTheModel}) {
  Prefetcher prefetcher;
  prefetcher.setViewCount(places.size());
  TimePoint now{};
  for (int step = 0; step < 10; ++step, now += milliseconds(25))
    for (size_t place = 0; place < places.size(); ++place) prefetcher.record(place, places[place](step), now);
  prefetcher.lookAhead(model, kOptions, now);
  return prefetcher.requests();
}

std::set<BlobUse> usesOf(const std::vector<Request>& requests) {
  std::set<BlobUse> uses;
  for (const Request& request : requests) uses.insert(request.use);
  return uses;
}

TEST(Prefetcher, requestsTheBlobsThatAMovingCameraWillNeed) {
  const SyntheticModel tree({.seed = 3});
  EXPECT_FALSE(askedAhead(coarseModel(tree, 1ull << 30)).empty());
}

TEST(Prefetcher, requestsTheBlobsOfAllInstancesOnce) {
  const SyntheticModel tree({.seed = 3});
  const Model model = coarseModel(tree, 1ull << 30);
  const std::vector<Request> together = askedAhead(model, {standing, towardsTheModel, beside});
  std::set<BlobUse> of_each = usesOf(askedAhead(model, {towardsTheModel}));
  of_each.merge(usesOf(askedAhead(model, {beside})));
  EXPECT_FALSE(of_each.empty());
  EXPECT_EQ(usesOf(together), of_each);
  EXPECT_EQ(together.size(), of_each.size());
  EXPECT_TRUE(askedAhead(model, {standing, standing}).empty());
}

TEST(Prefetcher, countsABlobAsUsedIfAnyInstanceShowsIt) {
  const SyntheticModel tree({.seed = 3});
  const Model model = coarseModel(tree, 1ull << 30);
  const std::vector<Request> requests = askedAhead(model);
  const auto mesh = std::ranges::find(requests, BlobKind::kMesh, [](const Request& w) { return w.use.kind; });
  ASSERT_NE(mesh, requests.end());
  Prefetcher prefetcher;
  prefetcher.asked(*mesh);
  prefetcher.arrived(mesh->blob, mesh->use);
  auto elsewhere = std::make_shared<Cut>();
  CutPart& part = elsewhere->parts.emplace_back();
  part.node = mesh->use.mesh.node;
  part.lod = mesh->use.mesh.lod;
  part.visible = true;
  const ViewCuts view_cuts{{std::make_shared<Cut>(), elsewhere}, nullptr};
  prefetcher.needed(&view_cuts, {}, {});
  EXPECT_EQ(prefetcher.counts().used, 1u);
}

TEST(Prefetcher, limitsTheUnusedBlobsThatItRemembers) {
  Prefetcher prefetcher;
  for (uint32_t number = 1; number <= kMaxUnusedPrefetches + 1000; ++number)
    prefetcher.asked({{number, 10, {}}, {BlobKind::kMesh, {NodeKey{number}, 0}}});
  EXPECT_EQ(prefetcher.counts().requested, kMaxUnusedPrefetches);
}

TEST(Prefetcher, treatsANewNumberOfInstancesAsNoMotion) {
  const SyntheticModel tree({.seed = 3});
  const Model model = coarseModel(tree, 1ull << 30);
  Prefetcher prefetcher;
  TimePoint now{};
  for (size_t count : {1, 2}) {
    prefetcher.setViewCount(count);
    now += milliseconds(200);
    for (size_t place = 0; place < count; ++place)
      prefetcher.record(place, towardsTheModel(10 * static_cast<int>(count)), now);
  }
  prefetcher.lookAhead(model, kOptions, now);
  EXPECT_TRUE(prefetcher.requests().empty());
}

TEST(Prefetcher, leavesAShareOfTheMemoryToTheView) {
  const SyntheticModel tree({.seed = 3});
  const Model roomy = coarseModel(tree, 1ull << 30);
  // Meshes get 3/4 of the budget, and prefetching 3/4 of that.
  const uint64_t half_full_bytes = roomy.meshes().bytes() * 16 / 9;
  EXPECT_TRUE(askedAhead(coarseModel(tree, half_full_bytes - 16)).empty());
  EXPECT_FALSE(askedAhead(coarseModel(tree, half_full_bytes + 64)).empty());
}

}  // namespace
}  // namespace lode::core
