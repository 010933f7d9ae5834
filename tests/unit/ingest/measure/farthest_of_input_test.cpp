#include "server/ingest/measure/farthest_of_input.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "server/ingest/measure/surface_samples.h"
#include "server/ingest/measure/triangle_tree.h"
#include "server/ingest/simplify/collapse.h"
#include "tests/support/loose_pieces.h"
#include "tests/support/node_meshes.h"

namespace lode::ingest {
namespace {

NodeMesh meshOf(const std::vector<glm::uvec3>& points, const std::vector<glm::u32vec3>& triangles) {
  NodeMesh mesh;
  for (const glm::uvec3 point : points) mesh.positions.push_back(packPosition(point));
  mesh.wedge_position.resize(points.size());
  std::iota(mesh.wedge_position.begin(), mesh.wedge_position.end(), 0u);
  mesh.lca_depth.assign(points.size(), kNeverLocked);
  mesh.triangles = triangles;
  return mesh;
}

FarthestOfInput farthestWithPlace(const SimplifiedMesh& lod, const NodeMesh& input, float lower_bound = 0) {
  const LodSurface surface(lod.mesh);
  return farthestOfInput(lod, input, surface, placesOn(lod, input, surface.walk()), lower_bound);
}

float farthestPlaceOfInput(const SimplifiedMesh& lod, const NodeMesh& input, float lower_bound = 0) {
  return farthestWithPlace(lod, input, lower_bound).steps;
}

void expectWhatDensePointsFind(const NodeMesh& input, const std::array<size_t, 2>& targets) {
  collapse(input, targets, {}, [&](size_t, SimplifiedMesh&& lod) {
    const TriangleTree tree(lod.mesh);
    double found = 0;
    for (const glm::dvec3 point : test::pointsOver(input, 16))
      found = std::max<double>(found, tree.distance(glm::vec3(point)));
    const float measured = farthestPlaceOfInput(lod, input);
    EXPECT_GE(1.021 * measured, found);
    EXPECT_LE(measured, 1.05 * found);
  });
}

TEST(FarthestOfInput, agreesWithDensePointsOnASphere) {
  expectWhatDensePointsFind(test::nodeOf(test::makeSphere(60, 40)), {1200, 100});
}

TEST(FarthestOfInput, agreesWithDensePointsIfPiecesVanish) {
  Mesh soup;
  test::addLoosePieces(soup, {.pieces = 60, .largest = 20, .extent = 4000});
  expectWhatDensePointsFind(test::nodeOf(soup), {150, 40});
}

/// The LOD is a ridge; the original is the ridge and a flat triangle under it.
struct Ridge {
  NodeMesh input;
  SimplifiedMesh lod;

  Ridge() {
    input = meshOf({{0, 0, 0}, {0, 100, 0}, {100, 0, 80}, {100, 100, 80}, {200, 0, 0}, {200, 100, 0}},
                   {{0, 2, 1}, {1, 2, 3}, {2, 4, 3}, {3, 4, 5}});
    lod = {input, {0, 1, 2, 3, 4, 5}};
    input.triangles.emplace_back(0, 4, 5);
  }
};

TEST(FarthestOfInput, findsAPlaceInsideATriangleWithCornersOnTheLod) {
  const Ridge ridge;
  EXPECT_NEAR(farthestPlaceOfInput(ridge.lod, ridge.input), 80 / std::hypot(1, 0.8), 1.5);
}

TEST(FarthestOfInput, givesThePlaceInsideATriangleAndANearCorner) {
  const Ridge ridge;
  const FarthestOfInput farthest = farthestWithPlace(ridge.lod, ridge.input);
  ASSERT_TRUE(farthest.inside);
  const glm::uvec3 place = unpackPosition(farthest.inside->position);
  EXPECT_NEAR(place.x, 100, 2);
  EXPECT_EQ(place.z, 0);
  EXPECT_EQ(farthest.inside->deviation, farthest.steps);
  EXPECT_EQ(farthest.inside->near, 0);
}

TEST(FarthestOfInput, givesNoPlaceNearerThanTheKnownDistance) {
  const Ridge ridge;
  EXPECT_FALSE(farthestWithPlace(ridge.lod, ridge.input, 70).inside);
}

TEST(FarthestOfInput, givesNoPlaceAtAPositionOfTheInput) {
  Ridge ridge;
  ridge.input.positions[3] = packPosition({100, 100, 180});
  ridge.lod.remap[3] = kVanished;
  EXPECT_FALSE(farthestWithPlace(ridge.lod, ridge.input).inside);
}

/// Reference implementation: measures every triangle.
float farthestOfEveryTriangle(const SimplifiedMesh& lod, const NodeMesh& input) {
  const TriangleTree tree(lod.mesh);
  std::vector<MeasuredPoint> beside;
  for (const PositionCode position : input.positions) {
    const glm::vec3 at(unpackPosition(position));
    const TriangleTree::Nearest nearest = tree.nearest(at);
    beside.push_back({at, nearest.distance, nearest.triangle});
  }
  const LodSurface surface(lod.mesh);
  FarthestInTriangle farthest(surface, 0, 0);
  for (const glm::u32vec3& t : input.triangles)
    farthest.process({beside[input.wedge_position[t.x]], beside[input.wedge_position[t.y]],
                      beside[input.wedge_position[t.z]]});
  return farthest.largest();
}

/// A grid with random heights of up to half its spacing.
NodeMesh roughGrid(uint32_t seed) {
  constexpr uint32_t kQuads = 24, kSpacing = 256;
  test::MeshOptions options;
  options.extent = kQuads * kSpacing;
  Mesh mesh = test::makeGrid(kQuads, kQuads, options);
  std::mt19937 random(seed);
  for (PositionCode& position : mesh.positions)
    position = packPosition(unpackPosition(position) + glm::uvec3(0, 0, random() % (kSpacing / 2)));
  return test::nodeOf(mesh);
}

TEST(FarthestOfInput, isTooSmallForAtMostOneInAHundredLodsOfRoughGrids) {
  size_t lods = 0, too_small = 0;
  for (uint32_t seed = 1; seed <= 500; ++seed) {
    const NodeMesh input = roughGrid(seed);
    const size_t all = input.triangles.size();
    collapse(input, std::array{all / 2, all / 4}, {}, [&](size_t, SimplifiedMesh&& lod) {
      ++lods;
      if (1.021 * farthestPlaceOfInput(lod, input) < farthestOfEveryTriangle(lod, input)) ++too_small;
    });
  }
  EXPECT_EQ(lods, 1000u);
  EXPECT_LE(100 * too_small, lods);
}

TEST(FarthestOfInput, countsVanishedTriangles) {
  const NodeMesh near = meshOf({{0, 0, 0}, {100, 0, 0}, {0, 100, 0}}, {{0, 1, 2}});
  NodeMesh input = near;
  input.positions.push_back(packPosition({0, 0, 500}));
  input.wedge_position.push_back(3);
  input.lca_depth.push_back(kNeverLocked);
  input.triangles.emplace_back(0, 1, 3);
  EXPECT_FLOAT_EQ(farthestPlaceOfInput({near, {0, 1, 2, kVanished}}, input), 500);
}

TEST(FarthestOfInput, isNeverBelowTheKnownDistance) {
  const NodeMesh mesh = test::nodeOf(test::makeGrid(4, 4));
  std::vector<uint32_t> same(mesh.positions.size());
  std::iota(same.begin(), same.end(), 0u);
  EXPECT_EQ(farthestPlaceOfInput({mesh, same}, mesh, 7), 7);
}

}  // namespace
}  // namespace lode::ingest
