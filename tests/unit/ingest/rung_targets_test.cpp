#include "server/ingest/rung_targets.h"

#include <gtest/gtest.h>

namespace lode::ingest {
namespace {

TEST(RungTargets, halveUntilTheNodesBudget) {
  EXPECT_EQ(rungTargets(40000, 100, 5, 16384), (std::vector<size_t>{20000, 10000}));
}

TEST(RungTargets, stopAtFourTimesTheLockedVertices) {
  EXPECT_EQ(rungTargets(40000, 6000, 5, 16384), (std::vector<size_t>{20000}));
}

TEST(RungTargets, takeStepsOfTheSquareRootOfTwoNearTheRoot) {
  EXPECT_EQ(rungTargets(20000, 0, 2, 9000), (std::vector<size_t>{14142, 10000, 7071}));
}

TEST(RungTargets, alwaysReduceOnce) { EXPECT_EQ(rungTargets(100, 0, 5, 16384), (std::vector<size_t>{50})); }

TEST(RungTargets, goDownTo512AtTheRoot) {
  const std::vector<size_t> targets = rungTargets(16000, 0, 0, 16384);
  EXPECT_LE(targets.back(), kRootTriangles);
  EXPECT_GT(targets[targets.size() - 2], kRootTriangles);
}

TEST(RungTargets, areNoneForASmallRoot) { EXPECT_TRUE(rungTargets(512, 0, 0, 16384).empty()); }

}  // namespace
}  // namespace lode::ingest
