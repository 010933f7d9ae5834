#include "server/ingest/measure/surface_samples.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "server/ingest/measure/triangle_tree.h"
#include "server/ingest/simplify/collapse.h"
#include "tests/support/node_meshes.h"

namespace lode::ingest {
namespace {

TEST(SurfaceSamples, keepTheWorstNearEachPositionAndTheLargestOthers) {
  std::vector<SurfaceSample> samples;
  for (uint32_t i = 0; i < 1000; ++i)
    samples.push_back({packPosition({i, 0, 0}), i >= 900 ? 100.f + static_cast<float>(i) : 1.f, i / 10});
  std::vector<SurfaceSample> shuffled = samples;
  std::shuffle(shuffled.begin(), shuffled.end(), std::mt19937(4));
  selectSamples(samples, 100, 150);
  selectSamples(shuffled, 100, 150);
  const auto byPosition = [](const SurfaceSample& a, const SurfaceSample& b) {
    return a.position < b.position;
  };
  std::sort(samples.begin(), samples.end(), byPosition);
  std::sort(shuffled.begin(), shuffled.end(), byPosition);
  ASSERT_EQ(samples.size(), 150u);
  for (size_t i = 0; i < samples.size(); ++i) EXPECT_EQ(samples[i].position, shuffled[i].position);
  std::set<uint32_t> near;
  for (const SurfaceSample& sample : samples) near.insert(sample.near);
  EXPECT_EQ(near.size(), 100u);
  EXPECT_EQ(samples[90].deviation, 1009);  // the largest deviation near position 90, after 90 other samples
  EXPECT_EQ(samples.back().deviation, 1099);
}

TEST(SurfaceSamples, stayNearEveryPositionEvenAboveTheLimit) {
  std::vector<SurfaceSample> samples;
  for (uint32_t i = 0; i < 1000; ++i) samples.push_back({packPosition({i, 0, 0}), 1, i / 2});
  selectSamples(samples, 500, 10);
  EXPECT_EQ(samples.size(), 500u);
}

TEST(SurfaceSamples, includeEveryPositionThatNeverMoved) {
  NodeMesh mesh = test::nodeOf(test::makeGrid(3, 3));
  mesh.lca_depth[2] = 1;
  mesh.lca_depth[5] = 2;
  mesh.lca_depth[7] = 3;
  std::vector<SurfaceSample> samples;
  addLockedPositions(samples, mesh, 3);
  ASSERT_EQ(samples.size(), 2u);
  EXPECT_EQ(samples[0].near, 2u);
  EXPECT_EQ(samples[1].position, mesh.positions[5]);
  EXPECT_EQ(samples[1].deviation, 0);
}

TEST(SurfaceSamples, countAPlaceOnceWithItsLargestDeviation) {
  const PositionCode place = packPosition({1, 1, 1});
  std::vector<SurfaceSample> samples{{place, 1, 5}, {place, 3, 5}, {place, 2, 6}};
  dropDuplicates(samples);
  ASSERT_EQ(samples.size(), 2u);
  EXPECT_EQ(samples[0].deviation, 3);
  EXPECT_EQ(samples[1].near, 6u);
}

TEST(SurfaceSamples, agreeWithBruteForce) {
  const NodeMesh input = test::nodeOf(test::makeSphere(60, 40));
  std::vector<SurfaceSample> samples;
  for (uint32_t i = 0; i < input.positions.size(); ++i) samples.push_back({input.positions[i], 0, i});
  collapse(input, std::array<size_t, 2>{1200, 100}, {}, [&](size_t, SimplifiedMesh&& lod) {
    const TriangleTree to_lod(lod.mesh);
    float forward = 0;
    for (const PositionCode position : input.positions)
      forward = std::max(forward, to_lod.distance(glm::vec3(unpackPosition(position))));
    const LodSurface surface(lod.mesh);
    float largest = 0;
    for (const Deviation& d :
         deviationsFrom(lod, input, surface, placesOn(lod, input, surface.walk()), samples))
      largest = std::max(largest, d.steps);
    EXPECT_FLOAT_EQ(largest, forward);
  });
}

TEST(SurfaceSamples, lieInsideUnusuallyLargeTriangles) {
  NodeMesh mesh = test::nodeOf(test::makeGrid(40, 40));
  EXPECT_TRUE(samplesInside(mesh).empty());
  const auto first = static_cast<uint32_t>(mesh.positions.size());
  const auto wedge = static_cast<uint32_t>(mesh.wedge_position.size());
  for (const glm::uvec3 corner :
       {glm::uvec3(0, 0, 9), glm::uvec3(1 << 20, 0, 9), glm::uvec3(0, 1 << 20, 9)}) {
    mesh.wedge_position.push_back(static_cast<uint32_t>(mesh.positions.size()));
    mesh.positions.push_back(packPosition(corner));
  }
  mesh.triangles.emplace_back(wedge, wedge + 1, wedge + 2);
  const std::vector<SurfaceSample> samples = samplesInside(mesh);
  EXPECT_GT(samples.size(), 30u);
  for (const SurfaceSample& sample : samples) {
    const glm::uvec3 at = unpackPosition(sample.position);
    EXPECT_EQ(sample.near, first);
    EXPECT_EQ(at.z, 9u);
    EXPECT_LE(at.x + at.y, 1u << 20);
  }
}

TEST(SurfaceSamples, areEmptyForAMeshWithoutArea) {
  NodeMesh mesh = test::nodeOf(test::makeGrid(4, 4));
  mesh.positions.assign(mesh.positions.size(), mesh.positions[0]);
  EXPECT_TRUE(samplesInside(mesh).empty());
  EXPECT_TRUE(samplesInside(NodeMesh{}).empty());
}

TEST(SurfaceSamples, areMeasuredWhereNothingIsLeftNearThem) {
  const NodeMesh mesh = test::nodeOf(test::makeGrid(4, 4));
  SimplifiedMesh lod{mesh, std::vector<uint32_t>(mesh.positions.size(), kVanished)};
  std::vector<SurfaceSample> samples;
  const PositionCode away = packPosition(unpackPosition(mesh.positions[0]) + glm::uvec3(0, 0, 70));
  samples.push_back({away, 0, kVanished});
  samples.push_back({mesh.positions[0], 0, 0});
  const LodSurface surface(mesh);
  const std::vector<Deviation> deviations =
      deviationsFrom(lod, mesh, surface, placesOn(lod, mesh, surface.walk()), samples);
  EXPECT_FLOAT_EQ(deviations[0].steps, TriangleTree(mesh).distance(glm::vec3(unpackPosition(away))));
  EXPECT_NE(deviations[0].near, kVanished);
  EXPECT_EQ(deviations[1].steps, 0);
}

}  // namespace
}  // namespace lode::ingest
