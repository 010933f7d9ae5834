#include "client/app/window/scene/paint.h"

#include <gtest/gtest.h>

namespace lode::app {
namespace {

/// A triangle with a black, a white and a white corner, and texture coordinates (0, 0), (1, 0) and (0, 1).
core::CutPart paintedPart(uint8_t attributes) {
  auto mesh = std::make_shared<Mesh>();
  mesh->attributes.bits = attributes;
  for (const glm::u16vec2 corner : {glm::u16vec2(0, 0), {1, 0}, {0, 1}}) {
    mesh->positions.push_back(packPosition({corner.x, corner.y, 0}));
    VertexAttributes& vertex = mesh->vertex_attributes.emplace_back();
    if (corner == glm::u16vec2(0, 0)) vertex.colour = {0, 0, 0, 255};
    vertex.texture = corner * uint16_t{32768};
  }
  mesh->triangles = {{0, 1, 2}};
  core::CutPart part;
  part.mesh = std::move(mesh);
  return part;
}

core::Hit hitOf(const core::CutPart& part, const glm::dvec3& weights) {
  core::Hit hit;
  hit.part = &part;
  hit.weights = weights;
  return hit;
}

/// An image of 600 x 1 texels in two levels, of which only the given tiles are resident.
core::Cut texturedCut(const std::vector<core::TileKey>& there) {
  auto set = std::make_shared<TextureSet>();
  set->uv_scale_exponent = 1;
  Texture& texture = set->textures.emplace_back();
  texture.width = 600;
  texture.height = 1;
  core::Cut cut;
  cut.textures = set;
  for (const core::TileKey& key : there) {
    auto image = std::make_shared<TileImage>();
    image->size = tileImageSize(*set, key);
    for (uint32_t y = 0; y < image->size.y; ++y)
      for (uint32_t x = 0; x < image->size.x; ++x)
        image->texels.emplace_back(key.level == 0 ? x + key.x : 9, 10 * key.level, 0, 255);
    cut.tiles.push_back({key, image});
  }
  return cut;
}

TEST(Paint, isMixedInLinearLightBetweenTheVertices) {
  const core::CutPart part = paintedPart(AttributeSet::kColour);
  EXPECT_EQ(paintAt(hitOf(part, {0.5, 0.25, 0.25}), {}), glm::u8vec3(188));
}

TEST(Paint, isAbsentIfTheModelHasNone) {
  const core::CutPart plain = paintedPart(AttributeSet::kNormal);
  EXPECT_FALSE(paintAt(hitOf(plain, {0.5, 0.25, 0.25}), {}));
  const core::CutPart textured = paintedPart(AttributeSet::kTexture);
  EXPECT_FALSE(paintAt(hitOf(textured, {0.5, 0.25, 0.25}), texturedCut({})));
}

TEST(Paint, isTheTexelUnderThePoint) {
  const core::CutPart part = paintedPart(AttributeSet::kTexture);
  const core::Cut cut = texturedCut({{1, 0, 0, 0}, {0, 0, 0, 0}, {0, 0, 0, 1}});
  const double left = 30.5 / 600, right = 510.5 / 600;
  EXPECT_EQ(paintAt(hitOf(part, {0.5 - left, left, 0.5}), cut), glm::u8vec3(32, 0, 0));
  EXPECT_EQ(paintAt(hitOf(part, {0.9 - right, right, 0.1}), cut), glm::u8vec3(5, 0, 0));
}

TEST(Paint, isACoarserTexelIfTheFinerOneIsNotResident) {
  const core::CutPart part = paintedPart(AttributeSet::kTexture);
  EXPECT_EQ(paintAt(hitOf(part, {0.5, 0.25, 0.25}), texturedCut({{1, 0, 0, 0}})), glm::u8vec3(9, 10, 0));
}

TEST(Paint, isTheTexelTimesTheVertexColour) {
  const core::CutPart part = paintedPart(AttributeSet::kTexture | AttributeSet::kColour);
  EXPECT_EQ(paintAt(hitOf(part, {1, 0, 0}), texturedCut({{1, 0, 0, 0}})), glm::u8vec3(0));
}

}  // namespace
}  // namespace lode::app
