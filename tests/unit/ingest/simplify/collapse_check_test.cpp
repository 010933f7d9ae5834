#include "server/ingest/simplify/collapse_check.h"

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

#include "tests/support/node_meshes.h"

namespace lode::ingest {
namespace {

// Marks of one check must not affect the next check, or harmless collapses would be refused.
TEST(CollapseCheck, findsTheSameOfAnEdgeWhateverItLookedAtBefore) {
  const CollapseMesh mesh(test::nodeOf(test::makeGrid(12, 12)), 0);
  EdgeSurroundings around(mesh);
  CollapseCheck used(mesh);
  const std::vector<CollapseMesh::Edge> edges = test::edgesOf(mesh);
  std::mt19937 random(3);
  size_t allowed = 0;
  for (int i = 0; i < 4000; ++i) {
    const CollapseMesh::Edge& edge = edges[random() % edges.size()];
    const CollapseLimits limits{.least_cosine = random() % 2 ? 0.999 : 0.3};
    const glm::dvec3 middle = (mesh.point(edge.u) + mesh.point(edge.v)) / 2.0;
    around.gather(edge.u, edge.v);
    const CollapseFinding expected = CollapseCheck(mesh).check(around, middle, limits);
    const CollapseFinding found = used.check(around, middle, limits);
    allowed += expected.allowed;
    ASSERT_EQ(found.allowed, expected.allowed) << i;
    ASSERT_EQ(found.folds, expected.folds) << i;
  }
  EXPECT_GT(allowed, 1000u);
}

/// Returns true if a triangle (a, b, from) keeps its shape within the limits when its third corner moves.
bool keepsShape(glm::dvec3 a, glm::dvec3 b, glm::dvec3 from, glm::dvec3 to, const CollapseLimits& limits) {
  const auto shape = [&](glm::dvec3 c) {
    const double longest = std::max({glm::distance(a, b), glm::distance(b, c), glm::distance(c, a)});
    return glm::length(glm::cross(b - a, c - a)) / (longest * longest);
  };
  const glm::dvec3 before = glm::cross(b - a, from - a), after = glm::cross(b - a, to - a);
  if (glm::length(before) == 0) return true;
  if (glm::dot(before, after) <= limits.least_cosine * glm::length(before) * glm::length(after)) return false;
  return shape(to) >= std::min(limits.least_shape, shape(from));
}

// Covers ends without triangles of their own, and with odd numbers of them.
TEST(CollapseCheck, allowsACollapseIfEachTriangleAroundAllowsIt) {
  constexpr CollapseLimits kStrict{.least_cosine = 0.5, .least_shape = 0.3, .link_condition = false};
  size_t allowed = 0, bare_ends = 0, looks = 0;
  for (uint32_t seed = 1; seed <= 20; ++seed) {
    const CollapseMesh mesh(test::makeTangle(60, 50, seed), 0);
    EdgeSurroundings around(mesh);
    CollapseCheck check(mesh);
    for (const CollapseMesh::Edge& edge : test::edgesOf(mesh)) {
      around.gather(edge.u, edge.v);
      bare_ends += around.ofU().empty() != around.ofV().empty();
      for (const double share : {0.0, 0.2, 1.0}) {
        const glm::dvec3 at_u = mesh.point(edge.u), at_v = mesh.point(edge.v);
        const glm::dvec3 to = at_u + share * (at_v - at_u);
        const auto keepsAll = [&](std::span<const EdgeSurroundings::Side> sides, glm::dvec3 from) {
          return from == to || std::ranges::all_of(sides, [&](const auto& side) {
                   return keepsShape(mesh.point(side.a), mesh.point(side.b), from, to, kStrict);
                 });
        };
        const bool expected = keepsAll(around.ofU(), at_u) && keepsAll(around.ofV(), at_v);
        EXPECT_EQ(check.check(around, to, kStrict).allowed, expected)
            << edge.u << ' ' << edge.v << ' ' << share;
        allowed += expected;
        ++looks;
      }
    }
  }
  EXPECT_GT(bare_ends, 100u);
  EXPECT_GT(allowed, looks / 10);
  EXPECT_LT(allowed, looks * 9 / 10);
}

}  // namespace
}  // namespace lode::ingest
