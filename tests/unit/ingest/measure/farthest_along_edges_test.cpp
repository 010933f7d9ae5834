#include <algorithm>
#include <array>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "server/ingest/measure/farthest_of_lod.h"
#include "server/ingest/measure/triangle_tree.h"
#include "server/ingest/mesh/mesh_welder.h"
#include "server/ingest/simplify/cluster.h"
#include "tests/support/node_meshes.h"

namespace lode::ingest {
namespace {

float farthestPlaceOf(const SimplifiedMesh& lod, const NodeMesh& input, float lower_bound) {
  return farthestAlongEdges(lod, LodInput(input, 0), sourcesOf(lod, input), lower_bound);
}

std::vector<Segment> edgesOf(const NodeMesh& mesh) {
  std::vector<Segment> edges;
  const auto at = [&](uint32_t wedge) {
    return glm::vec3(unpackPosition(mesh.positions[mesh.wedge_position[wedge]]));
  };
  for (const glm::u32vec3& t : mesh.triangles)
    edges.insert(edges.end(), {{at(t.x), at(t.y)}, {at(t.y), at(t.z)}, {at(t.z), at(t.x)}});
  return edges;
}

TEST(FarthestAlongEdges, agreesWithDensePoints) {
  for (uint32_t seed = 1; seed <= 4; ++seed) {
    const NodeMesh input = test::nodeOf(test::makeSphere(60, 40, {.attributes = {}, .seed = seed}));
    cluster(input, std::array<size_t, 2>{1200, 100}, {}, [&](size_t, SimplifiedMesh&& lod) {
      const TriangleTree tree(input);
      float found = 0;
      for (const auto& [from, to] : edgesOf(lod.mesh))
        for (int i = 0; i <= 100; ++i)
          found = std::max(found, tree.distance(glm::mix(from, to, static_cast<float>(i) / 100)));
      EXPECT_NEAR(farthestPlaceOf(lod, input, 0), found, 0.021f * found) << seed;
    });
  }
}

/// A comb: a back from (0, 0) to (900, 100), with teeth of 100 x 800 above it at intervals of 300.
NodeMesh combedMesh() {
  NodeMesh mesh;
  const auto add = [&](uint32_t x, uint32_t y) {
    mesh.positions.push_back(packPosition({x, y, 0}));
    mesh.wedge_position.push_back(static_cast<uint32_t>(mesh.wedge_position.size()));
    return static_cast<uint32_t>(mesh.positions.size() - 1);
  };
  const std::array<uint32_t, 6> xs{0, 100, 400, 500, 800, 900};
  std::array<uint32_t, 6> low, high;
  for (size_t i = 0; i < xs.size(); ++i) {
    low[i] = add(xs[i], 0);
    high[i] = add(xs[i], 100);
  }
  const auto addQuad = [&](uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({a, c, d});
  };
  for (size_t i = 0; i + 1 < xs.size(); ++i) addQuad(low[i], low[i + 1], high[i + 1], high[i]);
  for (size_t i = 0; i < xs.size(); i += 2)
    addQuad(high[i], high[i + 1], add(xs[i + 1], 900), add(xs[i], 900));
  mesh.lca_depth.assign(mesh.positions.size(), kNeverLocked);
  return mesh;
}

TEST(FarthestAlongEdges, findsNotchesUnderAnEdgeWhoseMiddleIsNear) {
  const NodeMesh input = combedMesh();
  SimplifiedMesh lod{input, std::vector<uint32_t>(input.positions.size())};
  std::iota(lod.remap.begin(), lod.remap.end(), 0u);
  const auto at = [&](uint32_t x, uint32_t y) {
    const auto found = std::ranges::find(input.positions, packPosition({x, y, 0}));
    return static_cast<uint32_t>(found - input.positions.begin());
  };
  lod.mesh.triangles.push_back({at(0, 900), at(900, 900), at(500, 900)});
  EXPECT_NEAR(farthestPlaceOf(lod, input, 0), 150, 3);
}

TEST(FarthestAlongEdges, isNeverBelowTheKnownDistance) {
  const NodeMesh mesh = test::nodeOf(test::makeGrid(4, 4));
  SimplifiedMesh same{mesh, std::vector<uint32_t>(mesh.positions.size())};
  std::iota(same.remap.begin(), same.remap.end(), 0u);
  EXPECT_EQ(farthestPlaceOf(same, mesh, 7), 7);
}

}  // namespace
}  // namespace lode::ingest
