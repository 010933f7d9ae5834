#include "client/core/textures/texture_footprint.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <gtest/gtest.h>

namespace lode::core {
namespace {

/// A set with one texture of 3 x 2 tiles and coordinates code / 2^14, from 0 to 4.
TextureSet setOf(uint32_t width = 1500, uint32_t height = 1000) {
  TextureSet set;
  set.uv_scale_exponent = 2;
  set.textures.push_back({"a", width, height, {}});
  return set;
}

constexpr double kCodes = 1 << 14;  // codes per repetition

Mesh triangleOf(std::array<glm::dvec2, 3> uv, uint16_t material = 0) {
  Mesh mesh;
  mesh.attributes.bits = AttributeSet::kTexture | AttributeSet::kMaterial;
  const glm::uvec3 corners[] = {{0, 0, 0}, {1000, 0, 0}, {0, 1000, 0}};
  for (int i = 0; i < 3; ++i) {
    mesh.positions.push_back(packPosition(corners[i]));
    VertexAttributes attributes;
    attributes.material = material;
    attributes.texture = glm::u16vec2(glm::round(uv[i] * kCodes));
    mesh.vertex_attributes.push_back(attributes);
  }
  mesh.triangles = {{0, 1, 2}};
  return mesh;
}

std::vector<glm::uvec2> placesOf(const TextureFootprint& footprint) {
  std::vector<glm::uvec2> places;
  for (const TouchedTile& tile : footprint.tiles) places.emplace_back(tile.x, tile.y);
  return places;
}

using Places = std::vector<glm::uvec2>;

TEST(TextureFootprint, hasTheTileThatATriangleLiesIn) {
  const Mesh mesh = triangleOf({{{0.05, 0.95}, {0.2, 0.95}, {0.05, 0.8}}});  // v up: near the top
  EXPECT_EQ(placesOf(makeFootprint(mesh, setOf(), 1)), (Places{{0, 0}}));
  const Mesh low = triangleOf({{{0.8, 0.05}, {0.9, 0.05}, {0.8, 0.2}}});
  EXPECT_EQ(placesOf(makeFootprint(low, setOf(), 1)), (Places{{2, 1}}));
}

TEST(TextureFootprint, leavesOutTilesThatALongTrianglePasses) {
  const Mesh diagonal = triangleOf({{{0.01, 0.99}, {0.99, 0.01}, {0.99, 0.02}}});
  const Places places = placesOf(makeFootprint(diagonal, setOf(1524, 1524), 1));
  EXPECT_EQ(std::count(places.begin(), places.end(), glm::uvec2(1, 1)), 1);
  EXPECT_EQ(std::count(places.begin(), places.end(), glm::uvec2(2, 0)), 0);
  EXPECT_EQ(std::count(places.begin(), places.end(), glm::uvec2(0, 2)), 0);
}

TEST(TextureFootprint, wrapsRepeatedCoordinatesIntoTheImage) {
  const Mesh inside = triangleOf({{{0.05, 0.95}, {0.2, 0.95}, {0.05, 0.8}}});
  const Mesh repeated = triangleOf({{{3.05, 2.95}, {3.2, 2.95}, {3.05, 2.8}}});
  EXPECT_EQ(placesOf(makeFootprint(repeated, setOf(), 1)), placesOf(makeFootprint(inside, setOf(), 1)));
  const Mesh across = triangleOf({{{0.95, 0.95}, {1.05, 0.95}, {0.95, 0.9}}});
  EXPECT_EQ(placesOf(makeFootprint(across, setOf(), 1)), (Places{{0, 0}, {2, 0}}));
}

TEST(TextureFootprint, hasAllTilesWhenATriangleSpansMoreThanTheImage) {
  const Mesh wide = triangleOf({{{0, 0}, {3, 0}, {0, 0.1}}});
  const TextureFootprint footprint = makeFootprint(wide, setOf(), 1);
  EXPECT_TRUE(footprint.tiles.empty());
  ASSERT_EQ(footprint.whole.size(), 1u);
  // 3 x 1500 texels per 1000 steps one way and 100 the other: a ratio above 8.
  EXPECT_NEAR(footprint.whole[0].texels_per_model, 4.5 / 8, 0.01);
}

TEST(TextureFootprint, endsAtTheBoundaryOfTheImage) {
  const Mesh whole = triangleOf({{{0.5, 0.5}, {1, 0.5}, {1, 1}}});
  for (const glm::uvec2 place : placesOf(makeFootprint(whole, setOf(), 1))) EXPECT_GE(place.x, 1u);
}

TEST(TextureFootprint, measuresTexelDensityInItsSparsestDirection) {
  // 750 texels per 1000 steps of 0.5 one way, 500 the other.
  const Mesh mesh = triangleOf({{{0, 0.5}, {0.5, 0.5}, {0, 1}}});
  for (const TouchedTile& tile : makeFootprint(mesh, setOf(), 0.5).tiles)
    EXPECT_NEAR(tile.texels_per_model, 1.0, 0.01);
}

TEST(TextureFootprint, limitsDegenerateCoordinatesToEightTimesTheMeanDensity) {
  Mesh mesh = triangleOf({{{0.1, 0.9}, {0.2, 0.9}, {0.1, 0.75}}});
  const float alone = makeFootprint(mesh, setOf(), 1).tiles.at(0).texels_per_model;
  const Mesh dot = triangleOf({{{0.1, 0.9}, {0.1 + 1.0 / kCodes, 0.9}, {0.1, 0.9 - 1.0 / kCodes}}});
  for (size_t i = 0; i < 3; ++i) {
    mesh.positions.push_back(dot.positions[i]);
    mesh.vertex_attributes.push_back(dot.vertex_attributes[i]);
  }
  mesh.triangles.push_back({3, 4, 5});
  const float both = makeFootprint(mesh, setOf(), 1).tiles.at(0).texels_per_model;
  EXPECT_NEAR(both, alone / std::sqrt(2.f) / 8, 0.01 * alone);
}

TEST(TextureFootprint, countsCoordinatesOnALineWithAnEighthOfTheirTexels) {
  const Mesh line = triangleOf({{{0.1, 0.9}, {0.2, 0.9}, {0.1, 0.9}}});
  EXPECT_NEAR(makeFootprint(line, setOf(), 1).tiles.at(0).texels_per_model, 0.15 / 8, 0.001);
}

TEST(TextureFootprint, favoursTrianglesWithSparserTexels) {
  // Two triangles of equal size; texels are ten times as far apart on one.
  Mesh mesh = triangleOf({{{0.1, 0.9}, {0.2, 0.9}, {0.1, 0.75}}});
  const Mesh sparse = triangleOf({{{0.1, 0.9}, {0.11, 0.9}, {0.1, 0.885}}});
  const float close = makeFootprint(mesh, setOf(), 1).tiles.at(0).texels_per_model;
  for (size_t i = 0; i < 3; ++i) {
    mesh.positions.push_back(sparse.positions[i]);
    mesh.vertex_attributes.push_back(sparse.vertex_attributes[i]);
  }
  mesh.triangles.push_back({3, 4, 5});
  const float both = makeFootprint(mesh, setOf(), 1).tiles.at(0).texels_per_model;
  EXPECT_GT(both, 0.1f * close);
  EXPECT_LT(both, 0.2f * close);
}

TEST(TextureFootprint, countsDegenerateTrianglesForTilesButNotForDensity) {
  Mesh mesh = triangleOf({{{0.1, 0.9}, {0.2, 0.9}, {0.1, 0.8}}});
  const float alone = makeFootprint(mesh, setOf(), 1).tiles.at(0).texels_per_model;
  const Mesh point = triangleOf({{{0.15, 0.85}, {0.15, 0.85}, {0.15, 0.85}}});
  for (size_t i = 0; i < 3; ++i) {
    mesh.positions.push_back(point.positions[i]);
    mesh.vertex_attributes.push_back(point.vertex_attributes[i]);
  }
  mesh.triangles.push_back({3, 4, 5});
  EXPECT_EQ(makeFootprint(mesh, setOf(), 1).tiles.at(0).texels_per_model, alone);
  EXPECT_EQ(placesOf(makeFootprint(point, setOf(), 1)), (Places{{0, 0}}));
}

TEST(TextureFootprint, isByTextureAndEmptyWithoutOne) {
  TextureSet set = setOf();
  set.textures.push_back({"b", 100, 100, {}});
  set.textures.push_back({"missing", 0, 0, {}});
  const std::array<glm::dvec2, 3> uv{{{0.1, 0.9}, {0.2, 0.9}, {0.1, 0.8}}};
  EXPECT_EQ(makeFootprint(triangleOf(uv, 1), set, 1).tiles.at(0).texture, 1u);
  EXPECT_TRUE(makeFootprint(triangleOf(uv, 2), set, 1).tiles.empty());
  EXPECT_TRUE(makeFootprint(triangleOf(uv, 3), set, 1).tiles.empty());
  Mesh plain = triangleOf(uv);
  plain.attributes.bits = AttributeSet::kColour;
  EXPECT_TRUE(makeFootprint(plain, set, 1).tiles.empty());
}

TEST(TextureFootprint, isTheWholeImageForATooCostlyMesh) {
  TextureSet set = setOf(kMaxTextureEdgePx, kMaxTextureEdgePx);
  Mesh mesh = triangleOf({{{0.01, 0.99}, {0.99, 0.01}, {0.99, 0.02}}});
  const size_t tiles = size_t{tilesAcross(set.textures[0], 0)} * tilesDown(set.textures[0], 0);
  EXPECT_LT(makeFootprint(mesh, set, 1).tiles.size(), tiles / 10);
  EXPECT_TRUE(makeFootprint(mesh, set, 1).whole.empty());
  mesh.triangles.resize(2 * kMaxTileTests / tiles, mesh.triangles[0]);
  EXPECT_TRUE(makeFootprint(mesh, set, 1).tiles.empty());
  EXPECT_EQ(makeFootprint(mesh, set, 1).whole.size(), 1u);
}

TEST(TextureFootprint, limitsItsTilesToTheSizeOfItsMesh) {
  // Half of a texture of 33 x 33 tiles, above the limit of a triangle; then a small one within the rest.
  TextureSet set = setOf(32 * kTileInnerPx + 1, 32 * kTileInnerPx + 1);
  set.textures.push_back({"b", 1500, 1000, {}});
  Mesh mesh = triangleOf({{{0, 0}, {1, 0}, {0, 1}}});
  const Mesh small = triangleOf({{{0.05, 0.95}, {0.2, 0.95}, {0.05, 0.8}}}, 1);
  mesh.positions.insert(mesh.positions.end(), small.positions.begin(), small.positions.end());
  mesh.vertex_attributes.insert(mesh.vertex_attributes.end(), small.vertex_attributes.begin(),
                                small.vertex_attributes.end());
  mesh.triangles.push_back({3, 4, 5});
  const TextureFootprint footprint = makeFootprint(mesh, set, 1);
  ASSERT_EQ(footprint.whole.size(), 1u);
  EXPECT_EQ(footprint.whole[0].texture, 0u);
  EXPECT_NEAR(footprint.whole[0].texels_per_model, set.textures[0].width / 1000.0, 0.1);
  ASSERT_EQ(footprint.tiles.size(), 1u);
  EXPECT_EQ(footprint.tiles[0].texture, 1u);

  mesh.triangles.resize(200, mesh.triangles[0]);  // enough triangles for those tiles
  EXPECT_TRUE(makeFootprint(mesh, set, 1).whole.empty());
  EXPECT_GT(makeFootprint(mesh, set, 1).tiles.size(), maxTouchedTiles(2));
}

TEST(TextureFootprint, survivesCoordinatesBeyondAllBounds) {
  TextureSet set = setOf();
  set.uv_origin = {0x1p60, -0x1p60};
  set.uv_scale_exponent = kMaxUvExponent;
  EXPECT_EQ(makeFootprint(triangleOf({{{0, 0}, {3, 0}, {0, 3}}}), set, 1).whole.size(), 1u);
}

}  // namespace
}  // namespace lode::core
