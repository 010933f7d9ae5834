#include "server/ingest/build/idle_rungs.h"

#include <vector>

#include <gtest/gtest.h>

namespace lode::ingest {
namespace {

Node parentOf(uint32_t triangles) {
  Node parent;
  parent.rungs.resize(1);
  parent.rungs[0].triangles = triangles;
  parent.rungs[0].error_model = 1;
  return parent;
}

/// Errors of what is left of a node with one rung that its parent is made of, and four spare ones.
std::vector<float> leftBelow(const Node& parent) {
  FinishedNode finished;
  for (const float error : {0.5f, 0.9f, 1.5f, 2.5f, 4.0f}) {
    finished.node.rungs.emplace_back().error_model = error;
    finished.payloads.push_back({static_cast<uint64_t>(8 * error), 0});
  }
  finished.node.spare_rungs = 4;
  leaveOutIdleRungs(finished, parent);
  std::vector<float> errors;
  for (size_t r = 0; r < finished.node.rungs.size(); ++r) {
    errors.push_back(finished.node.rungs[r].error_model);
    EXPECT_EQ(finished.payloads[r].offset, static_cast<uint64_t>(8 * errors.back()));
  }
  EXPECT_EQ(finished.node.spare_rungs + 1, errors.size());
  return errors;
}

TEST(IdleRungs, areThoseBetweenThatAreFartherOffThanTheParentsFinest) {
  EXPECT_EQ(leftBelow(parentOf((1 << 19) - 1)), (std::vector<float>{0.5f, 0.9f, 4.0f}));
}

TEST(IdleRungs, areOfALargeParentThoseThatAreMoreThanTwiceAsFarOff) {
  EXPECT_EQ(leftBelow(parentOf(1 << 19)), (std::vector<float>{0.5f, 0.9f, 1.5f, 4.0f}));
}

}  // namespace
}  // namespace lode::ingest
