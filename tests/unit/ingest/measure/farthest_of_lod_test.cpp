#include "server/ingest/measure/farthest_of_lod.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "server/ingest/measure/surface_samples.h"
#include "server/ingest/measure/triangle_tree.h"
#include "server/ingest/mesh/mesh_welder.h"
#include "server/ingest/simplify/collapse.h"
#include "tests/support/node_meshes.h"

namespace lode::ingest {
namespace {

float farthestPlaceOfLod(const SimplifiedMesh& lod, const NodeMesh& input, float lower_bound) {
  return farthestOfLod(lod, LodInput(input, 0), placesOn(lod, input, SurfaceWalk(lod.mesh)),
                       sourcesOf(lod, input), lower_bound);
}

TEST(FarthestOfLod, agreesWithDensePointsWithinItsMargin) {
  constexpr double kPointMargin = 1.12;  // margin that lodDeviation() adds
  for (uint32_t seed = 1; seed <= 12; ++seed) {
    const NodeMesh input = test::nodeOf(test::makeSphere(60, 40, {.attributes = {}, .seed = seed}));
    collapse(input, std::array<size_t, 2>{1200, 100}, {}, [&](size_t, SimplifiedMesh&& lod) {
      const TriangleTree tree(input);
      double found = 0;
      for (const glm::dvec3 point : test::pointsOver(lod.mesh, 24))
        found = std::max<double>(found, tree.distance(glm::vec3(point)));
      const float measured = farthestPlaceOfLod(lod, input, 0);
      EXPECT_GE(kPointMargin * measured, found) << seed;
      EXPECT_LE(measured, 1.001 * found) << seed;
    });
  }
}

/// A square of 64 x 64 cells with a narrow pit, 400 deep, in one half and a wide hill, 200 high, in the
/// other.
NodeMesh pitAndHill() {
  constexpr uint32_t kCells = 64, kCell = 100, kGround = 1000;
  const auto cone = [](glm::vec2 at, glm::vec2 middle, float radius) {
    return std::max(0.f, 1 - glm::distance(at, middle) / radius);
  };
  NodeMesh mesh;
  for (uint32_t y = 0; y <= kCells; ++y)
    for (uint32_t x = 0; x <= kCells; ++x) {
      const glm::vec2 at(x * kCell, y * kCell);
      const float height = 200 * cone(at, {4800, 4800}, 1200) - 400 * cone(at, {800, 800}, 300);
      mesh.wedge_position.push_back(static_cast<uint32_t>(mesh.positions.size()));
      mesh.positions.push_back(
          packPosition({x * kCell, y * kCell, kGround + static_cast<uint32_t>(static_cast<int>(height))}));
    }
  for (uint32_t y = 0; y < kCells; ++y)
    for (uint32_t x = 0; x < kCells; ++x) {
      const uint32_t a = y * (kCells + 1) + x, b = a + 1, c = a + kCells + 1, d = c + 1;
      mesh.triangles.push_back({a, b, c});
      mesh.triangles.push_back({b, d, c});
    }
  mesh.lca_depth.assign(mesh.positions.size(), kNeverLocked);
  return mesh;
}

TEST(FarthestOfLod, findsAPitBehindAnInitiallyFartherTriangle) {
  const NodeMesh input = pitAndHill();
  const auto last = static_cast<uint32_t>(input.positions.size()) - 1;
  const std::array<uint32_t, 4> corners{0, 64, last - 64, last};
  SimplifiedMesh lod{{}, std::vector<uint32_t>(input.positions.size(), kVanished)};
  for (uint32_t i = 0; i < corners.size(); ++i) {
    lod.remap[corners[i]] = i;
    lod.mesh.positions.push_back(input.positions[corners[i]]);
    lod.mesh.wedge_position.push_back(i);
    lod.mesh.lca_depth.push_back(kNeverLocked);
  }
  lod.mesh.triangles = {{0, 1, 2}, {1, 3, 2}};
  const float pit = TriangleTree(input).distance({800, 800, 1000});
  const float hill = TriangleTree(input).distance({4800, 4800, 1000});
  ASSERT_GT(pit, 1.1f * hill);
  EXPECT_GE(farthestPlaceOfLod(lod, input, 0), pit * 0.999f);
}

TEST(FarthestOfLod, isNeverBelowTheKnownDistance) {
  const NodeMesh mesh = test::nodeOf(test::makeGrid(4, 4));
  SimplifiedMesh same{mesh, std::vector<uint32_t>(mesh.positions.size())};
  std::iota(same.remap.begin(), same.remap.end(), 0u);
  EXPECT_EQ(farthestPlaceOfLod(same, mesh, 7), 7);
}

}  // namespace
}  // namespace lode::ingest
