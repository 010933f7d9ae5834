#include "server/ingest/pipeline/pack.h"

#include <vector>

#include <gtest/gtest.h>

namespace lode::ingest {
namespace {

Node parentOf(uint32_t triangles) {
  Node parent;
  parent.lods.resize(1);
  parent.lods[0].triangles = triangles;
  parent.lods[0].error_model = 1;
  return parent;
}

/// Returns the errors of the remaining LODs of a node with one regular and four far LODs.
std::vector<float> leftBelow(const Node& parent) {
  FinishedNode finished;
  for (const float error : {0.5f, 0.9f, 1.5f, 2.5f, 4.0f}) {
    finished.node.lods.emplace_back().error_model = error;
    finished.payloads.push_back({static_cast<uint64_t>(8 * error), 0});
  }
  finished.node.far_lods = 4;
  removeRedundantFarLods(finished, parent);
  std::vector<float> errors;
  for (size_t r = 0; r < finished.node.lods.size(); ++r) {
    errors.push_back(finished.node.lods[r].error_model);
    EXPECT_EQ(finished.payloads[r].offset, static_cast<uint64_t>(8 * errors.back()));
  }
  EXPECT_EQ(finished.node.far_lods + 1, errors.size());
  return errors;
}

TEST(RedundantFarLods, haveLargerErrorsThanTheParentsFinest) {
  EXPECT_EQ(leftBelow(parentOf((1 << 19) - 1)), (std::vector<float>{0.5f, 0.9f, 4.0f}));
}

TEST(RedundantFarLods, haveMoreThanTwiceTheErrorOfALargeParentsFinest) {
  EXPECT_EQ(leftBelow(parentOf(1 << 19)), (std::vector<float>{0.5f, 0.9f, 1.5f, 4.0f}));
}

}  // namespace
}  // namespace lode::ingest
