#include "client/app/cli/cut_export.h"

#include <memory>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/texture_images.h"

namespace lode::app {
namespace {

constexpr AttributeSet kColoured{AttributeSet::kColour};

/// Returns a square of four vertices and one colour, with its left side at x.
std::shared_ptr<const Mesh> square(uint32_t x, AttributeSet attributes, uint8_t red = 255) {
  Mesh mesh;
  mesh.attributes = attributes;
  for (const glm::uvec3 corner : {glm::uvec3(x, 0, 0), {x + 1, 0, 0}, {x + 1, 1, 0}, {x, 1, 0}}) {
    mesh.positions.push_back(packPosition(corner));
    if (attributes.bits != 0) {
      VertexAttributes vertex;
      vertex.colour.r = red;
      mesh.vertex_attributes.push_back(vertex);
    }
  }
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return std::make_shared<const Mesh>(std::move(mesh));
}

core::Cut cutOf(const std::vector<std::shared_ptr<const Mesh>>& meshes) {
  core::Cut cut;
  for (size_t i = 0; i < meshes.size(); ++i) {
    cut.parts.push_back({kRootKey.child(static_cast<unsigned>(i)), 0, true, 0, meshes[i]});
    cut.triangles += meshes[i]->triangles.size();
  }
  return cut;
}

/// Returns the positions of all triangle corners, in the order of the mesh.
std::vector<PositionCode> corners(const Mesh& mesh) {
  std::vector<PositionCode> codes;
  for (const glm::u32vec3& t : mesh.triangles)
    for (int i = 0; i < 3; ++i) codes.push_back(mesh.positions[t[i]]);
  return codes;
}

TEST(WeldCut, mergesVerticesThatPartsShare) {
  for (const AttributeSet attributes : {AttributeSet{}, kColoured}) {
    const auto left = square(0, attributes), right = square(1, attributes);
    const Mesh whole = weldCut(cutOf({left, right}), attributes);
    EXPECT_EQ(whole.attributes, attributes);
    EXPECT_EQ(whole.positions.size(), 6u);
    EXPECT_EQ(whole.vertex_attributes.size(), attributes.bits ? 6u : 0u);
    std::vector<PositionCode> expected = corners(*left);
    const std::vector<PositionCode> more = corners(*right);
    expected.insert(expected.end(), more.begin(), more.end());
    EXPECT_EQ(corners(whole), expected);
  }
}

TEST(WeldCut, keepsVerticesOfOnePlaceApartIfTheirAttributesDiffer) {
  const Mesh whole = weldCut(cutOf({square(0, kColoured, 10), square(1, kColoured, 20)}), kColoured);
  ASSERT_EQ(whole.positions.size(), 8u);
  for (size_t v = 0; v < 8; ++v) EXPECT_EQ(whole.vertex_attributes[v].colour.r, v < 4 ? 10 : 20);
}

TEST(WeldCut, keepsTheOrderOfThePartsAndTheirVertices) {
  const auto only = square(7, kColoured);
  EXPECT_EQ(weldCut(cutOf({only}), kColoured), *only);
}

TEST(WeldCut, givesAnEmptyMeshOfAnEmptyCut) {
  const Mesh whole = weldCut(core::Cut{}, kColoured);
  EXPECT_TRUE(whole.positions.empty() && whole.triangles.empty());
}

constexpr uint32_t kWidth = 1100, kHeight = 520;

/// An image in which each texel's colour encodes its position.
test::TextureImages gradient(uint8_t alpha = 255) {
  return test::TextureImages(kWidth, kHeight, [alpha](uint32_t x, uint32_t y) {
    return glm::u8vec4(x & 255, y & 255, x >> 8, alpha);
  });
}

using Key = std::tuple<uint32_t, uint32_t, uint32_t>;  // level, x, y

std::vector<core::ResidentTile> tilesOf(const test::TextureImages& images, const std::vector<Key>& keys) {
  std::vector<core::ResidentTile> tiles;
  for (const auto& [level, x, y] : keys)
    tiles.push_back({{level, 0, y, x}, std::make_shared<const TileImage>(images.tile(level, x, y))});
  return tiles;
}

std::vector<Key> allOfLevel(const Texture& texture, uint32_t level) {
  std::vector<Key> keys;
  for (uint32_t y = 0; y < tilesDown(texture, level); ++y)
    for (uint32_t x = 0; x < tilesAcross(texture, level); ++x) keys.emplace_back(level, x, y);
  return keys;
}

std::vector<glm::u8vec4> rowOf(const ResidentImage& image, uint32_t y) {
  std::vector<glm::u8vec4> row(image.size().x);
  image.fill(y, row);
  return row;
}

TEST(ResidentImage, isIncompleteWithoutItsCoarsestLevel) {
  const test::TextureImages images = gradient();
  EXPECT_FALSE(ResidentImage(images.texture(), 0, tilesOf(images, {{0, 1, 0}})).isComplete());
}

TEST(ResidentImage, leavesOutTilesOfOtherTextures) {
  const test::TextureImages images = gradient();
  EXPECT_FALSE(ResidentImage(images.texture(), 1, tilesOf(images, {{2, 0, 0}})).isComplete());
}

TEST(ResidentImage, hasTheSizeOfTheFinestLevelThatHasATile) {
  const test::TextureImages images = gradient();
  const auto coarse = tilesOf(images, {{2, 0, 0}, {1, 0, 0}});
  EXPECT_EQ(ResidentImage(images.texture(), 0, coarse).size(), glm::uvec2(550, 260));
}

TEST(ResidentImage, isTheOriginalIfAllTilesAreResident) {
  const test::TextureImages images = gradient();
  std::vector<Key> keys = allOfLevel(images.texture(), 0);
  keys.emplace_back(2, 0, 0);
  const auto tiles = tilesOf(images, keys);
  const ResidentImage image(images.texture(), 0, tiles);
  ASSERT_EQ(image.size(), glm::uvec2(kWidth, kHeight));
  for (uint32_t y = 0; y < kHeight; ++y) {
    const auto row = rowOf(image, y);
    for (uint32_t x = 0; x < kWidth; ++x) ASSERT_EQ(row[x], glm::u8vec4(x & 255, y & 255, x >> 8, 255));
  }
}

TEST(ResidentImage, repeatsCoarserTexelsWhereTheFinestLevelLacksATile) {
  const test::TextureImages images = gradient();
  const auto tiles = tilesOf(images, {{0, 1, 0}, {2, 0, 0}});
  const ResidentImage image(images.texture(), 0, tiles);
  const TileImage coarsest = images.tile(2, 0, 0);
  const auto row = rowOf(image, 301);
  for (uint32_t x = 0; x < kWidth; ++x) {
    const bool is_fine = x / kTileInnerPx == 1;
    const glm::u8vec4 coarse = coarsest.texels[size_t{301 / 4 + kTileGutterPx} * coarsest.size.x + x / 4 + 2];
    ASSERT_EQ(row[x], is_fine ? glm::u8vec4(x & 255, 301 & 255, x >> 8, 255) : coarse) << x;
  }
}

TEST(ResidentImage, hasAlphaWhereATexelIsNotOpaque) {
  const test::TextureImages opaque = gradient(), clear = gradient(200);
  const auto opaque_tiles = tilesOf(opaque, {{2, 0, 0}}), clear_tiles = tilesOf(clear, {{2, 0, 0}});
  EXPECT_FALSE(ResidentImage(opaque.texture(), 0, opaque_tiles).hasAlpha());
  EXPECT_TRUE(ResidentImage(clear.texture(), 0, clear_tiles).hasAlpha());
}

}  // namespace
}  // namespace lode::app
