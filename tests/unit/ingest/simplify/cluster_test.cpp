#include "server/ingest/simplify/cluster.h"

#include <algorithm>
#include <map>
#include <set>

#include <gtest/gtest.h>

#include "tests/support/node_meshes.h"
#include "tests/support/surface_distance.h"
#include "tests/unit/ingest/simplify/simplifier_fixture.h"

namespace lode::ingest {
namespace {

std::vector<Snapshot> clusteredTo(const NodeMesh& mesh, const std::vector<size_t>& targets,
                                  const CollapseOptions& options = {}) {
  std::vector<Snapshot> snapshots;
  cluster(mesh, targets, options, [&](size_t target, SimplifiedMesh&& snapshot) {
    snapshots.push_back({target, std::move(snapshot.mesh)});
  });
  return snapshots;
}

TEST(Cluster, deliversEveryTargetInOrder) {
  const NodeMesh mesh = test::nodeOf(test::makeSphere(60, 40));
  const std::vector<size_t> targets{2400, 1200, 600, 100, 0};
  const std::vector<Snapshot> snapshots = clusteredTo(mesh, targets);
  ASSERT_EQ(snapshots.size(), targets.size());
  for (size_t i = 0; i < targets.size(); ++i) {
    EXPECT_EQ(snapshots[i].target, i);
    EXPECT_LE(snapshots[i].mesh.triangles.size(), targets[i]);
    EXPECT_GE(2 * snapshots[i].mesh.triangles.size(), targets[i]);
    expectSound(snapshots[i].mesh);
  }
}

TEST(Cluster, reducesManySmallPiecesToNothing) {
  for (uint32_t seed = 1; seed <= 8; ++seed) {
    const std::vector<Snapshot> snapshots = clusteredTo(test::makeTangle(900, 300, seed), {200, 50, 0});
    ASSERT_EQ(snapshots.size(), 3u);
    for (const Snapshot& snapshot : snapshots) expectSound(snapshot.mesh);
    EXPECT_TRUE(snapshots[2].mesh.triangles.empty());
  }
}

TEST(Cluster, reducesOneCellToOnePositionAndTheLockedOnes) {
  NodeMesh mesh = test::nodeOf(test::makeGrid(24, 16, with(AttributeSet::kColour)));
  lockOddEdges(mesh);
  const NodeMesh result = clusteredTo(mesh, {0}, {.node_depth = 2}).at(0).mesh;
  const auto interior = std::count(result.lca_depth.begin(), result.lca_depth.end(), kNeverLocked);
  EXPECT_EQ(interior, 1);
  expectSound(result);
}

TEST(Cluster, keepsClosedMeshesClosedWhateverIsLocked) {
  for (uint32_t seed = 1; seed <= 12; ++seed) {
    NodeMesh mesh =
        test::nodeOf(test::makeSphere(20 + seed, 14, with(seed % 2 ? AttributeSet::kAll : 0, seed)));
    lockSome(mesh, seed, 2 + seed);
    for (const Snapshot& snapshot : clusteredTo(mesh, {300, 200, 100, 50, 0}, {.node_depth = 2})) {
      EXPECT_TRUE(test::oddEdges(snapshot.mesh).empty());
      expectSound(snapshot.mesh);
    }
  }
}

TEST(Cluster, keepsEveryEdgeOfALockedBorder) {
  for (uint32_t seed = 1; seed <= 8; ++seed) {
    NodeMesh mesh = test::nodeOf(test::makeGrid(24, 16, with(seed % 2 ? AttributeSet::kAll : 0, seed)));
    lockOddEdges(mesh);
    const std::set<test::PositionEdge> border = test::oddEdges(mesh);
    for (const Snapshot& snapshot : clusteredTo(mesh, {300, 100, 0}, {.node_depth = 2}))
      EXPECT_EQ(test::oddEdges(snapshot.mesh), border);
  }
}

TEST(Cluster, keepsTheLockedBorderOfATangle) {
  for (uint32_t seed = 1; seed <= 8; ++seed) {
    NodeMesh mesh = test::makeTangle(80, 60, seed);
    lockOddEdges(mesh);
    const std::set<test::PositionEdge> border = test::oddEdges(mesh);
    for (const Snapshot& snapshot : clusteredTo(mesh, {50, 30, 0}, {.node_depth = 2})) {
      EXPECT_EQ(test::oddEdges(snapshot.mesh), border);
      expectSound(snapshot.mesh);
    }
  }
}

TEST(Cluster, leavesLockedPositionsAndTheirAttributesAlone) {
  MeshOptions options = with(AttributeSet::kNormal | AttributeSet::kColour);
  NodeMesh mesh = test::nodeOf(test::makeSphere(30, 20, options));
  lockSome(mesh, 7, 10);
  std::map<uint64_t, VertexAttributes> locked;
  for (size_t i = 0; i < mesh.wedge_position.size(); ++i) {
    const uint32_t position = mesh.wedge_position[i];
    if (mesh.lca_depth[position] == 1) locked[mesh.positions[position].value] = mesh.wedge_attributes[i];
  }
  const NodeMesh result = clusteredTo(mesh, {200}, {.node_depth = 2}).at(0).mesh;
  size_t found = 0;
  for (size_t i = 0; i < result.wedge_position.size(); ++i) {
    const uint32_t position = result.wedge_position[i];
    const auto known = locked.find(result.positions[position].value);
    if (known == locked.end()) continue;
    ++found;
    EXPECT_EQ(result.lca_depth[position], 1);
    EXPECT_EQ(result.wedge_attributes[i], known->second);
  }
  EXPECT_GT(found, 0u);
}

TEST(Cluster, deliversOnceIfItGetsStuck) {
  NodeMesh mesh = test::nodeOf(test::makeGrid(20, 20));
  lockOddEdges(mesh);
  const std::vector<Snapshot> snapshots = clusteredTo(mesh, {400, 10, 5}, {.node_depth = 2});
  ASSERT_EQ(snapshots.size(), 2u);
  EXPECT_EQ(snapshots[0].target, 0u);
  EXPECT_EQ(snapshots[1].target, 1u);
  EXPECT_GT(snapshots[1].mesh.triangles.size(), 10u);
}

TEST(Cluster, placesNothingOutsideTheModelsBox) {
  MeshOptions options;
  options.extent = 64;
  for (uint32_t seed = 1; seed <= 6; ++seed) {
    options.seed = seed;
    options.bump = 0.4;
    const Mesh sphere = test::makeSphere(16, 12, options);
    const glm::uvec3 max = test::boxOf(sphere).max;
    for (const Snapshot& snapshot :
         clusteredTo(test::nodeOf(sphere), {200, 100, 40, 10}, {.max_position = max})) {
      for (const PositionCode code : snapshot.mesh.positions)
        EXPECT_TRUE(glm::all(glm::lessThanEqual(unpackPosition(code), max)));
      expectSound(snapshot.mesh);
    }
  }
}

TEST(Cluster, keepsPositionsApartOnACrowdedLattice) {
  MeshOptions options;
  options.extent = 8;
  options.bump = 0.9;
  for (uint32_t seed = 1; seed <= 6; ++seed) {
    options.seed = seed;
    const NodeMesh mesh = test::nodeOf(test::makeGrid(8, 8, options));
    for (const Snapshot& snapshot : clusteredTo(mesh, {100, 60, 30, 10})) expectSound(snapshot.mesh);
  }
}

TEST(Cluster, isDeterministic) {
  const NodeMesh mesh = test::nodeOf(test::makeSphere(40, 30, with(AttributeSet::kAll)));
  const NodeMesh a = clusteredTo(mesh, {300}).at(0).mesh, b = clusteredTo(mesh, {300}).at(0).mesh;
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.wedge_attributes, b.wedge_attributes);
  EXPECT_EQ(a.triangles, b.triangles);
}

TEST(Cluster, survivesAnEmptyMesh) {
  const std::vector<Snapshot> snapshots = clusteredTo({}, {10, 0});
  ASSERT_EQ(snapshots.size(), 2u);
  EXPECT_TRUE(snapshots[1].mesh.triangles.empty());
}

TEST(Cluster, copesWithAFanOfThousands) {
  MeshOptions options;
  options.extent = 1 << 20;
  const NodeMesh mesh = test::nodeOf(test::makeSphere(20000, 2, options));
  const std::vector<Snapshot> snapshots = clusteredTo(mesh, {20000, 1000, 10});
  ASSERT_EQ(snapshots.size(), 3u);
  for (const Snapshot& snapshot : snapshots) EXPECT_TRUE(test::oddEdges(snapshot.mesh).empty());
}

TEST(Cluster, staysNearTheSurface) {
  MeshOptions options;
  options.extent = 1 << 14;
  const Mesh sphere = test::makeSphere(120, 80, options);
  const NodeMesh result = clusteredTo(test::nodeOf(sphere), {2000}).at(0).mesh;
  Mesh simplified;
  simplified.positions = result.positions;
  simplified.triangles = result.triangles;
  const test::TriangleSoup before = test::latticeSoup(sphere), after = test::latticeSoup(simplified);
  const test::SurfaceDistance distance = test::surfaceDistance(before, after, 20000);
  EXPECT_LT(distance.both.rms, 2e-3 * test::boxDiagonal(before));
  EXPECT_LT(distance.both.max, 2e-2 * test::boxDiagonal(before));
}

TEST(Cluster, mixesNothingAcrossASeam) {
  Mesh sheet = test::makeGrid(40, 20, with(AttributeSet::kColour | AttributeSet::kMaterial));
  for (VertexAttributes& attributes : sheet.vertex_attributes)
    attributes.colour = attributes.material == 0 ? glm::u8vec4(200, 0, 0, 255) : glm::u8vec4(0, 0, 200, 255);
  const NodeMesh result = clusteredTo(test::nodeOf(sheet), {200}).at(0).mesh;
  for (const VertexAttributes& attributes : result.wedge_attributes)
    EXPECT_EQ(attributes.colour,
              attributes.material == 0 ? glm::u8vec4(200, 0, 0, 255) : glm::u8vec4(0, 0, 200, 255));
  for (const glm::u32vec3 t : result.triangles) {
    EXPECT_EQ(result.wedge_attributes[t.x].material, result.wedge_attributes[t.y].material);
    EXPECT_EQ(result.wedge_attributes[t.x].material, result.wedge_attributes[t.z].material);
  }
}

}  // namespace
}  // namespace lode::ingest
