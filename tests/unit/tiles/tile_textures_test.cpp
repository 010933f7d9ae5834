#include "server/tiles/tile_textures.h"

#include <random>

#include <gtest/gtest.h>

#include "tests/support/test_meshes.h"
#include "tests/unit/tiles/textured_store.h"

namespace lode::tiles {
namespace {

using Source = TexturedPart::Source;

constexpr uint32_t kWidth = 1024, kHeight = 512;
constexpr double kSheetStep = 0.25;

/// Returns a grid that shows a rectangle of an image. @param least, most  codes at the corners.
Mesh gridShowing(glm::uvec2 least, glm::uvec2 most, uint16_t material = 0) {
  constexpr uint32_t kCells = 8;
  Mesh mesh = test::makeGrid(kCells, kCells, {.attributes = {AttributeSet::kTexture}});
  mesh.attributes.bits |= AttributeSet::kMaterial;
  for (uint32_t v = 0; v < mesh.positions.size(); ++v) {
    const glm::uvec2 cell(v % (kCells + 1), v / (kCells + 1));
    mesh.vertex_attributes[v].texture = glm::u16vec2(least + (most - least) * cell / kCells);
    mesh.vertex_attributes[v].material = material;
  }
  return mesh;
}

/// Appends a mesh to another one.
void append(Mesh& mesh, const Mesh& other) {
  const auto first = static_cast<uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), other.positions.begin(), other.positions.end());
  mesh.vertex_attributes.insert(mesh.vertex_attributes.end(), other.vertex_attributes.begin(),
                                other.vertex_attributes.end());
  for (const glm::u32vec3 t : other.triangles) mesh.triangles.push_back(t + first);
}

glm::dvec2 coordinatesOf(const TexturedPart& part, uint32_t vertex) {
  return glm::dvec2(part.coordinates.origin) +
         glm::dvec2(part.mesh.vertex_attributes[vertex].texture) * part.coordinates.step;
}

/// Calls use(vertex of the mesh, vertex of the part) for each corner. The part has all triangles of the mesh.
template <typename Use>
void forEachCorner(const Mesh& mesh, const TexturedPart& part, Use&& use) {
  ASSERT_EQ(part.mesh.triangles.size(), mesh.triangles.size());
  for (size_t i = 0; i < mesh.triangles.size(); ++i)
    for (int k = 0; k < 3; ++k) use(mesh.triangles[i][k], part.mesh.triangles[i][k]);
}

class TileTextures : public testing::Test {
 protected:
  TexturedLod texture(const Mesh& mesh, double error_model, const test::TexturedStore& store) {
    TextureLevels levels(store.reader());
    return textureLod(mesh, store.reader().textures(), kSheetStep, error_model, levels);
  }
  TexturedLod texture(const Mesh& mesh, double error_model) { return texture(mesh, error_model, store_); }

  const test::TextureImages image_{kWidth, kHeight, test::texelAt};
  const test::TexturedStore store_{{image_, image_}};
};

TEST_F(TileTextures, showTheSameTexelsInTheAtlasAsInTheImage) {
  Mesh mesh = gridShowing({6400, 12800}, {19200, 25600});
  append(mesh, gridShowing({40000, 1000}, {50000, 9000}, 1));
  const TexturedLod lod = texture(mesh, 0);
  ASSERT_EQ(lod.parts.size(), 1u);
  const TexturedPart& part = lod.parts[0];
  EXPECT_EQ(part.source, Source::kAtlas);
  const Image& atlas = lod.atlas->image;
  forEachCorner(mesh, part, [&](uint32_t given, uint32_t v) {
    EXPECT_EQ(part.mesh.positions[v], mesh.positions[given]);
    const glm::dvec2 uv = trueTextureCoordinates(store_.reader().textures(), mesh.vertex_attributes[given]);
    const glm::dvec2 wanted = glm::dvec2(uv.x, 1 - uv.y) * glm::dvec2(kWidth, kHeight);
    const glm::dvec2 at = coordinatesOf(part, v) * glm::dvec2(atlas.size);
    const glm::u8vec4 texel = atlas.at(uint32_t(at.x), uint32_t(at.y));
    const glm::dvec2 found(texel.r | (texel.b & 15) << 8, texel.g | (texel.b >> 4) << 8);
    EXPECT_LE(glm::distance(found + glm::fract(at), wanted), 0.2) << v;  // an eighth of a texel on each axis
  });
}

TEST_F(TileTextures, areAsFineAsTheErrorAndNotFiner) {
  const Mesh mesh = gridShowing({6400, 12800}, {19200, 25600});  // 200 x 100 texels on a side of 1024 units
  const double texel_model = std::sqrt(1024.0 * 1024.0 / (200 * 100));
  const auto edge = [&](double error_model) {
    const glm::uvec2 size = texture(mesh, error_model).atlas->image.size;
    return std::max(size.x, size.y);
  };
  const uint32_t finest = edge(0), margin = 2 * kGutterPx;
  EXPECT_NEAR(finest, 200 + margin, 2);
  EXPECT_EQ(edge(1.9 * texel_model), finest);
  EXPECT_NEAR(edge(2.2 * texel_model), 100 + margin, 2);
  EXPECT_NEAR(edge(8.8 * texel_model), 25 + margin, 2);
  EXPECT_EQ(texture(mesh, 1e9).parts[0].shared.level, 10u);  // one texel
}

TEST_F(TileTextures, shareAWholeLevelIfTheyNeedMostOfTheImage) {
  const Mesh mesh = gridShowing({0, 0}, {65535, 50000}, 1);
  const TexturedLod lod = texture(mesh, 0);
  ASSERT_EQ(lod.parts.size(), 1u);
  EXPECT_FALSE(lod.atlas);
  EXPECT_EQ(lod.parts[0].source, Source::kShared);
  EXPECT_EQ(lod.parts[0].shared, (SharedImage{1, 0}));
  forEachCorner(mesh, lod.parts[0], [&](uint32_t given, uint32_t v) {
    const glm::dvec2 uv = trueTextureCoordinates(store_.reader().textures(), mesh.vertex_attributes[given]);
    EXPECT_LE(glm::distance(coordinatesOf(lod.parts[0], v), glm::dvec2(uv.x, 1 - uv.y)), 1e-6);
  });
}

TEST_F(TileTextures, keepRepeatedImagesApartFromTheAtlas) {
  const test::TexturedStore repeated({image_, image_}, 3);  // coordinates up to 8
  Mesh mesh = gridShowing({0, 0}, {60000, 60000}, 0);
  append(mesh, gridShowing({8192, 8192}, {9000, 9000}, 1));
  const TexturedLod lod = texture(mesh, 0, repeated);
  ASSERT_EQ(lod.parts.size(), 2u);
  EXPECT_EQ(lod.parts[0].source, Source::kAtlas);
  EXPECT_EQ(lod.parts[1].source, Source::kShared);
  EXPECT_LT(lod.atlas->image.size.x, 200u);
  double most = 0;
  for (uint32_t v = 0; v < lod.parts[1].mesh.positions.size(); ++v)
    most = std::max(most, coordinatesOf(lod.parts[1], v).x);
  EXPECT_NEAR(most, 60000 * 8 / 65536.0, 1e-3);
}

TEST_F(TileTextures, leaveTrianglesWithoutAnImageInAPartOfTheirOwn) {
  Mesh mesh = gridShowing({6400, 12800}, {19200, 25600});
  append(mesh, gridShowing({0, 0}, {100, 100}, kNoMaterial));
  append(mesh, gridShowing({0, 0}, {100, 100}, 2));  // material without a texture
  const TexturedLod lod = texture(mesh, 0);
  ASSERT_EQ(lod.parts.size(), 2u);
  EXPECT_EQ(lod.parts[0].source, Source::kNone);
  EXPECT_EQ(lod.parts[0].mesh.triangles.size(), 2 * lod.parts[1].mesh.triangles.size());
}

TEST_F(TileTextures, takeCoarserLevelsThatFitTheLargestAtlas) {
  const test::TextureImages wide(60000, 16, test::texelAt);
  const test::TexturedStore store({wide, wide, wide});
  const TexturedLod lod = texture(gridShowing({0, 0}, {30000, 6000}), 0, store);
  ASSERT_TRUE(lod.atlas);
  EXPECT_LE(lod.atlas->image.size.x, kMostImagePx);
  const TexturedLod whole = texture(gridShowing({0, 0}, {65535, 65535}), 0, store);
  EXPECT_EQ(whole.parts[0].shared.level, 4u);  // 3,750 texels
}

TEST_F(TileTextures, showAPaletteAtItsFinestLevel) {
  const TexturedLod lod = texture(gridShowing({6400, 12800}, {6400, 12800}), 1e6);
  ASSERT_TRUE(lod.atlas);
  const glm::dvec2 at = coordinatesOf(lod.parts[0], 0) * glm::dvec2(lod.atlas->image.size);
  const glm::u8vec4 texel = lod.atlas->image.at(uint32_t(at.x), uint32_t(at.y));
  EXPECT_EQ(texel.r, 100);
}

}  // namespace
}  // namespace lode::tiles
