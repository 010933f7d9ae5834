#include "server/ingest/measure/rim_gap.h"

#include <cmath>

#include <gtest/gtest.h>

#include "server/ingest/mesh/mesh_edges.h"
#include "tests/support/node_meshes.h"

namespace lode::ingest {
namespace {

NodeMesh meshOf(std::vector<glm::uvec2> points, std::vector<glm::u32vec3> triangles) {
  NodeMesh mesh;
  for (const glm::uvec2 point : points) {
    mesh.wedge_position.push_back(static_cast<uint32_t>(mesh.positions.size()));
    mesh.positions.push_back(packPosition({point, 0}));
  }
  mesh.lca_depth.assign(points.size(), kNeverLocked);
  mesh.triangles = std::move(triangles);
  return mesh;
}

/// A square of two triangles, whose upper rim has a point in its middle that is higher by `bump`.
NodeMesh house(uint32_t bump) {
  return meshOf({{0, 0}, {100, 0}, {100, 100}, {50, 100 + bump}, {0, 100}},
                {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}});
}

TEST(RimGap, isHowFarARimThatWasCutShortIsFromTheOriginal) {
  const NodeMesh input = house(40);
  SimplifiedMesh flat{meshOf({{0, 0}, {100, 0}, {100, 100}, {0, 100}}, {{0, 1, 2}, {0, 2, 3}}),
                      {0, 1, 2, 3, 3}};
  const float of_middle = 40 * 50 / std::hypot(40.f, 50.f);  // from the new rim to either side of the roof
  const float gap = rimGap(flat, input, openEdges(input));
  EXPECT_GE(gap, of_middle * 0.999f);
  EXPECT_LE(gap, of_middle * 1.021f);
}

TEST(RimGap, isNothingWhereNothingHasMoved) {
  const NodeMesh input = house(40);
  EXPECT_EQ(rimGap({input, {0, 1, 2, 3, 4}}, input, openEdges(input)), 0);
}

TEST(RimGap, isNothingWhereNothingIsLeft) {
  const NodeMesh input = house(40);
  const SimplifiedMesh gone{{}, std::vector<uint32_t>(5, kVanished)};
  EXPECT_EQ(rimGap(gone, input, openEdges(input)), 0);
}

}  // namespace
}  // namespace lode::ingest
