#include "server/ingest/simplify/collapse_check.h"

#include <random>

#include <gtest/gtest.h>

#include "tests/support/node_meshes.h"

namespace lode::ingest {
namespace {

// What a look marks must not be taken for marks of the next: collapses that do no harm were refused.
TEST(CollapseCheck, findsTheSameOfAnEdgeWhateverItLookedAtBefore) {
  const CollapseMesh mesh(test::nodeOf(test::makeGrid(12, 12)), 0);
  CollapseCheck used(mesh);
  const std::vector<CollapseMesh::Edge> edges = test::edgesOf(mesh);
  std::mt19937 random(3);
  size_t allowed = 0;
  for (int i = 0; i < 4000; ++i) {
    const CollapseMesh::Edge& edge = edges[random() % edges.size()];
    const CollapseLimits limits{.least_cosine = random() % 2 ? 0.999 : 0.3};
    const glm::dvec3 middle = (mesh.point(edge.u) + mesh.point(edge.v)) / 2.0;
    const CollapseFinding expected = CollapseCheck(mesh).look(edge.u, edge.v, middle, limits);
    const CollapseFinding found = used.look(edge.u, edge.v, middle, limits);
    allowed += expected.allowed;
    ASSERT_EQ(found.allowed, expected.allowed) << i;
    ASSERT_EQ(found.folds, expected.folds) << i;
  }
  EXPECT_GT(allowed, 1000u);
}

}  // namespace
}  // namespace lode::ingest
