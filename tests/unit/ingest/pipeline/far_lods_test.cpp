#include <algorithm>
#include <map>
#include <optional>
#include <string>

#include <gtest/gtest.h>

#include "server/ingest/nodes/lod_targets.h"
#include "server/ingest/pipeline/build.h"
#include "server/sample/sample.h"
#include "server/store/reader.h"
#include "server/store/verify.h"
#include "tests/support/work_folder.h"

namespace lode::ingest {
namespace {

constexpr uint32_t kNodeCapacity = 512;
constexpr uint64_t kMuch = 8 * kNodeCapacity;  // triangles of the original below a node

/// A porous model with three levels of inner nodes, whose nodes have long borders.
class FarLods : public testing::Test {
 protected:
  explicit FarLods(const std::string& kind = "gyroid") {
    SampleOptions sample;
    sample.kind = kind;
    sample.triangles = 60'000;
    writeSample(sample, folder_ / "a.ply");
    BuildOptions options;
    options.input = folder_ / "a.ply";
    options.output = folder_ / "a.lode";
    options.triangles_per_node = kNodeCapacity;
    build(options);
    reader_.emplace(folder_ / "a.lode");
    for (const Node& node : reader_->nodes())
      for (NodeKey key = node.key; node.isLeaf(); key = key.parent()) {
        original_[key] += node.lods.front().triangles;
        if (key == kRootKey) break;
      }
  }

  test::WorkFolder folder_;
  std::optional<store::Reader> reader_;
  std::map<NodeKey, uint64_t> original_;  ///< triangles in the leaves below
};

TEST_F(FarLods, existAboveLargeSubtreesAndEndAtAQuarterOfTheCapacityOrTheBorder) {
  size_t nodes = 0;
  for (const Node& node : reader_->nodes()) {
    const bool may_have = node.key != kRootKey && !node.isLeaf() && original_.at(node.key) >= kMuch;
    const uint32_t limit = std::max(kNodeCapacity / 4, 2 * node.sourceLod().locked);
    EXPECT_EQ(node.far_lods > 0, may_have && node.sourceLod().triangles > limit) << node.key.value;
    if (node.far_lods == 0) continue;
    EXPECT_LE(node.lods.back().triangles, limit + limit / 4) << node.key.value;
    ++nodes;
  }
  EXPECT_GT(nodes, 5u);
}

/// Number of far LODs that the rule gives a node.
size_t farLodsOf(const Node& node, uint64_t original) {
  const LodRule rule{.depth = node.key.depth(),
                     .locked = node.sourceLod().locked,
                     .original_triangles = original,
                     .triangles_per_node = kNodeCapacity};
  return farLodTargets(node.sourceLod().triangles, rule).size();
}

TEST_F(FarLods, leaveOutThoseWithLargerErrorsThanTheParentsFinest) {
  size_t left_out = 0;
  for (const Node& node : reader_->nodes())
    if (node.far_lods > 0) left_out += farLodsOf(node, original_.at(node.key)) - node.far_lods;
  EXPECT_GT(left_out, 0u);
}

class FarLodsOfATerrain : public FarLods {
 protected:
  FarLodsOfATerrain() : FarLods("terrain") {}
};

TEST_F(FarLodsOfATerrain, includeThoseWithErrorsUpToTheParentsFinest) {
  size_t between = 0;
  for (const Node& node : reader_->nodes()) {
    if (node.far_lods == 0) continue;
    const float most = reader_->find(node.key.parent())->lods.front().error_model;
    for (size_t r = node.lods.size() - node.far_lods; r + 1 < node.lods.size(); ++r, ++between)
      EXPECT_LE(node.lods[r].error_model, most) << node.key.value;
  }
  EXPECT_GT(between, 0u);
}

TEST_F(FarLods, areNotTheInputOfTheParent) {
  std::map<NodeKey, uint64_t> input;
  for (const Node& node : reader_->nodes())
    if (node.key != kRootKey) input[node.key.parent()] += node.sourceLod().triangles;
  for (const auto& [key, triangles] : input)
    EXPECT_GE(reader_->find(key)->lods.front().triangles, triangles * 49 / 100) << key.value;
}

TEST_F(FarLods, leaveNoOpenEdgesInRandomCuts) {
  const store::VerifyReport report = store::verifyStore(folder_ / "a.lode", {.random_cuts = 30});
  EXPECT_EQ(report.cuts, 30u);
  EXPECT_EQ(report.open_edges, 0u);
}

}  // namespace
}  // namespace lode::ingest
