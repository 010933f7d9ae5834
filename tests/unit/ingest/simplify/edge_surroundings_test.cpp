#include "server/ingest/simplify/edge_surroundings.h"

#include <algorithm>
#include <set>
#include <utility>

#include <gtest/gtest.h>

#include "tests/support/node_meshes.h"

namespace lode::ingest {
namespace {

using Sides = std::multiset<std::pair<uint32_t, uint32_t>>;

Sides sidesOf(std::span<const EdgeSurroundings::Side> sides) {
  Sides result;
  for (const auto [a, b] : sides) result.emplace(a, b);
  return result;
}

/// Sides of the triangles at one end of an edge that do not have the other end.
Sides sidesAt(const CollapseMesh& mesh, uint32_t end, uint32_t other) {
  Sides result;
  for (const uint32_t corner : mesh.around(end)) {
    const uint32_t a = mesh.at(CollapseMesh::next(corner)), b = mesh.at(CollapseMesh::previous(corner));
    if (a != other && b != other) result.emplace(a, b);
  }
  return result;
}

TEST(EdgeSurroundings, listTheTrianglesAtEachEndAndTheApexesOfTheEdge) {
  const CollapseMesh mesh(test::nodeOf(test::makeGrid(6, 6)), 0);
  EdgeSurroundings around(mesh);
  for (const CollapseMesh::Edge& edge : test::edgesOf(mesh)) {
    around.gather(edge.u, edge.v);
    EXPECT_EQ(sidesOf(around.ofU()), sidesAt(mesh, edge.u, edge.v));
    EXPECT_EQ(sidesOf(around.ofV()), sidesAt(mesh, edge.v, edge.u));
    ASSERT_EQ(around.apexes().size(), edge.uses);
    for (const uint32_t apex : around.apexes()) {
      const Sides at_apex = sidesAt(mesh, apex, ~0u);
      EXPECT_TRUE(at_apex.contains({edge.u, edge.v}) || at_apex.contains({edge.v, edge.u}));
    }
  }
}

TEST(EdgeSurroundings, packCornersByFourAndPadWithTheLastTriangle) {
  const CollapseMesh mesh(test::nodeOf(test::makeGrid(6, 6)), 0);
  EdgeSurroundings around(mesh);
  for (const CollapseMesh::Edge& edge : test::edgesOf(mesh)) {
    around.gather(edge.u, edge.v);
    std::vector<EdgeSurroundings::Side> sides(around.ofU().begin(), around.ofU().end());
    sides.insert(sides.end(), around.ofV().begin(), around.ofV().end());
    ASSERT_EQ(around.places().size(), (sides.size() + 3) / 4);
    for (size_t i = 0; i < 4 * around.places().size(); ++i) {
      const auto [a, b] = sides[std::min(i, sides.size() - 1)];
      const EdgeSurroundings::FourSides& four = around.places()[i / 4];
      const auto at = [k = i % 4](const FourVectors& v) { return glm::dvec3(v.x[k], v.y[k], v.z[k]); };
      EXPECT_EQ(at(four.a), mesh.point(a));
      EXPECT_EQ(at(four.b), mesh.point(b));
    }
  }
}

TEST(EdgeSurroundings, haveNoApexesForAMissingEdge) {
  const CollapseMesh mesh(test::nodeOf(test::makeGrid(6, 6)), 0);
  EdgeSurroundings around(mesh);
  around.gather(0, 48);
  EXPECT_TRUE(around.apexes().empty());
}

}  // namespace
}  // namespace lode::ingest
