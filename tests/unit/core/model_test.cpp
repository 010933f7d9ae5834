#include "client/core/model.h"

#include <algorithm>
#include <optional>

#include <gtest/gtest.h>

#include "tests/unit/core/scripted_server.h"

namespace lode::core {
namespace {

using namespace fixture;

/// Memory of a decode job as the model counts it.
uint64_t workBytes(const DecodeJob& job) {
  return 2 * meshBytes(job.expected.vertices, job.expected.triangles, job.expected.attributes);
}

TEST(Model, limitsDecodeJobsToTheirMemoryShare) {
  const SyntheticModel synthetic({.seed = 3});
  const ScriptedServer server(synthetic);
  constexpr uint64_t kBudgetBytes = 1u << 20, kShareBytes = kBudgetBytes / kTransitBudgetShare;
  Model model(server.summary(), kBudgetBytes);
  model.take(server.summary().root_page, {BlobKind::kRootPage, {kRootKey, 0}},
             encodePage(synthetic.rootPage()));
  size_t taken = 0;
  for (const auto& [key, node] : synthetic.nodes())
    for (uint32_t lod = 0; lod < node.lods.size() && key.depth() <= 2; ++lod, ++taken)
      model.take(node.lods[lod].payload, {BlobKind::kMesh, {key, lod}}, Bytes(10));
  taken = model.decoding();
  ASSERT_GT(taken, 20u);
  size_t rounds = 0, finished = 0;
  for (std::vector<DecodeJob> jobs = model.takeDecodeJobs(); !jobs.empty(); jobs = model.takeDecodeJobs()) {
    uint64_t bytes = 0;
    for (const DecodeJob& job : jobs) bytes += workBytes(job);
    EXPECT_TRUE(jobs.size() == 1 || bytes <= kShareBytes) << bytes;
    EXPECT_EQ(model.decodingBytes(), bytes);
    for (const DecodeJob& job : jobs)
      model.finishDecode({job.blob, job.use, synthetic.mesh(job.use.mesh), nullptr, nullptr, ""});
    finished += jobs.size();
    ++rounds;
  }
  EXPECT_EQ(finished, taken);
  EXPECT_GT(rounds, 1u);
  EXPECT_EQ(model.undecodedBytes() + model.decodingBytes(), 0u);
}

TEST(Model, keepsNoMoreUndecodedBytesThanTheirShareAndOneBlob) {
  const SyntheticModel synthetic({.seed = 3, .payload_bytes_a_triangle = 100});
  const ScriptedServer server(synthetic);
  constexpr uint64_t kBudgetBytes = 1u << 20, kShareBytes = kBudgetBytes / kTransitBudgetShare;
  Model model(server.summary(), kBudgetBytes);
  model.take(server.summary().root_page, {BlobKind::kRootPage, {kRootKey, 0}},
             encodePage(synthetic.rootPage()));
  uint64_t offered_bytes = 0, largest_bytes = 0;
  std::optional<Request> last;
  for (const auto& [key, node] : synthetic.nodes())
    for (uint32_t lod = 0; lod < node.lods.size() && key.depth() <= 2; ++lod) {
      last = {node.lods[lod].payload, {BlobKind::kMesh, {key, lod}}};
      model.take(last->blob, last->use, Bytes(10));
      offered_bytes += last->blob.bytes;
      largest_bytes = std::max<uint64_t>(largest_bytes, last->blob.bytes);
    }
  ASSERT_GT(offered_bytes, 2 * (kShareBytes + largest_bytes));
  EXPECT_GT(model.undecodedBytes(), kShareBytes);
  EXPECT_LE(model.undecodedBytes(), kShareBytes + largest_bytes);
  EXPECT_TRUE(model.wants(*last)) << "it may be requested again";
}

TEST(Model, refusesACoarsestLodThatTakesFarMoreThanTheBudget) {
  const SyntheticModel synthetic({.seed = 3});
  const ScriptedServer server(synthetic);
  for (const uint32_t triangles : {1000u, kMaxLodTriangles}) {
    Model model(server.summary(), 16u << 20);
    HierarchyPage page = synthetic.rootPage();
    for (Lod& lod : page.nodes.front().lods) {
      lod.triangles = triangles;
      lod.vertices = 3 * triangles;
    }
    const auto take = [&] {
      model.take(server.summary().root_page, {BlobKind::kRootPage, {kRootKey, 0}}, encodePage(page));
    };
    if (triangles == 1000)
      EXPECT_NO_THROW(take());
    else
      EXPECT_THROW(take(), Error);
  }
}

TEST(Model, forgetsRefusalsAboveTheLimit) {
  const SyntheticModel synthetic({.seed = 3});
  const ScriptedServer server(synthetic);
  Model model(server.summary(), 1ull << 30);
  const Request first{{1, 10, {}}};
  for (uint32_t number = 1; number <= kMaxRefusedBlobs; ++number) model.lose({number, 10, {}}, "no");
  EXPECT_FALSE(model.wants(first));
  model.lose({kMaxRefusedBlobs + 1, 10, {}}, "no");
  EXPECT_TRUE(model.wants(first));
  EXPECT_EQ(model.failure(), "no");
}

TEST(Model, beginsWithTheNextFinerLodOnlyWhereTheCoarsestIsLost) {
  const SyntheticModel synthetic({.seed = 3});
  const ScriptedServer server(synthetic);
  for (const bool is_lost : {true, false}) {
    Model model(server.summary(), 1ull << 30);
    model.take(server.summary().root_page, {BlobKind::kRootPage, {kRootKey, 0}},
               encodePage(synthetic.rootPage()));
    const Request first = model.firstRequest().value();
    if (is_lost)
      model.lose(first.blob, "the server says no");
    else
      model.postpone(first.blob, "the server says no", kStart);
    ASSERT_EQ(model.firstRequest().has_value(), is_lost);
    if (!is_lost) continue;
    EXPECT_EQ(model.firstRequest()->use.mesh.lod, first.use.mesh.lod - 1);
  }
}

TEST(Model, ignoresLateResultsOfAReplacedBuild) {
  const SyntheticModel synthetic({.seed = 3});
  const ScriptedServer server(synthetic);
  Model model(server.summary(), 1ull << 30);
  model.take(server.summary().root_page, {BlobKind::kRootPage, {kRootKey, 0}},
             encodePage(synthetic.rootPage()));
  const Request first = model.firstRequest().value();
  model.take(first.blob, first.use, Bytes(10));
  ASSERT_EQ(model.takeDecodeJobs().size(), 1u);
  BlobRef of_before = first.blob;
  of_before.digest.bytes[0] ^= std::byte{1};
  model.finishDecode({of_before, first.use, synthetic.mesh(first.use.mesh), nullptr, nullptr, ""});
  EXPECT_EQ(model.decoding(), 1u);
  EXPECT_FALSE(model.meshes().contains(first.use.mesh));
}

}  // namespace
}  // namespace lode::core
