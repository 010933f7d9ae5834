#include "server/ingest/measure/lost_detail.h"

#include <array>
#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include "common/codec/octahedral.h"
#include "server/ingest/measure/surface_samples.h"
#include "server/ingest/simplify/collapse.h"
#include "tests/support/node_meshes.h"

namespace lode::ingest {
namespace {

constexpr uint32_t kWallCells = 64, kSpacing = 32;
constexpr float kWallSide = kWallCells * kSpacing;

/// Sets the attributes at a position from 0 to 1.
using Paint = std::function<void(glm::vec2 at, VertexAttributes& attributes)>;

/// A flat, painted square.
NodeMesh wall(uint8_t attributes, const Paint& paint) {
  Mesh mesh =
      test::makeGrid(kWallCells, kWallCells, {.attributes = {}, .extent = kWallCells * kSpacing, .bump = 0});
  mesh.attributes.bits = attributes;
  for (const PositionCode code : mesh.positions) {
    mesh.vertex_attributes.emplace_back();
    paint(glm::vec2(glm::uvec2(unpackPosition(code))) / kWallSide, mesh.vertex_attributes.back());
  }
  return test::nodeOf(mesh);
}

/// Simplifies a flat wall by geometry alone, so that only its paint can be lost.
float lostAt(size_t triangles, const NodeMesh& input) {
  float lost = -1;
  collapse(input, std::array{triangles}, {.attribute_weight = 0}, [&](size_t, SimplifiedMesh&& lod) {
    lost = lostDetail(lod, input, placesOn(lod, input, SurfaceWalk(lod.mesh)));
  });
  return lost;
}

void rings(glm::vec2 at, VertexAttributes& attributes) {
  const float radius = glm::length(at - 0.5f);
  attributes.colour = glm::u8vec4(static_cast<uint8_t>(127 + 120 * std::sin(40 * radius)), 80, 60, 255);
}

TEST(LostDetail, isZeroWithoutPaint) {
  EXPECT_EQ(lostAt(200, wall(AttributeSet::kColour, [](glm::vec2, VertexAttributes&) {})), 0);
}

TEST(LostDetail, isZeroForALinearGradient) {
  const NodeMesh even = wall(AttributeSet::kColour, [](glm::vec2 at, VertexAttributes& attributes) {
    attributes.colour =
        glm::u8vec4(static_cast<uint8_t>(200 * at.x), static_cast<uint8_t>(100 * at.y), 0, 255);
  });
  EXPECT_EQ(lostAt(500, even), 0);
}

TEST(LostDetail, hasTheSizeOfTheTrianglesOnAPaintedFlatWall) {
  const NodeMesh painted = wall(AttributeSet::kColour, rings);
  for (const size_t triangles : {2000u, 500u, 100u}) {
    const float side = kWallSide / std::sqrt(static_cast<float>(triangles));
    const float lost = lostAt(triangles, painted);
    EXPECT_GE(lost, 0.7f * side) << triangles;
    EXPECT_LE(lost, 4 * side) << triangles;
  }
}

TEST(LostDetail, countsNormals) {
  const Paint waves = [](glm::vec2 at, VertexAttributes& attributes) {
    attributes.normal = encodeOctahedral({std::sin(60 * at.x), 0, 1});
  };
  EXPECT_GT(lostAt(500, wall(AttributeSet::kNormal, waves)), 0);
}

TEST(LostDetail, measuresTheShiftOfATexture) {
  // The texture is squeezed in the middle by a tenth of its width, over the whole height.
  const NodeMesh squeezed = wall(AttributeSet::kTexture, [](glm::vec2 at, VertexAttributes& attributes) {
    const float bend = 0.1f * std::sin(3.14159f * at.x);
    attributes.texture = glm::u16vec2(60000 * (at.x + bend * (1 - at.x)), 60000 * at.y);
  });
  const float lost = lostAt(2, squeezed);
  EXPECT_GT(lost, 0.02f * kWallSide);
  EXPECT_LT(lost, 0.2f * kWallSide);
}

TEST(LostDetail, isZeroAtAKeptSeam) {
  Mesh mesh = test::makeGrid(kWallCells, kWallCells,
                             {.attributes = {AttributeSet::kMaterial}, .extent = 2048, .bump = 0});
  mesh.attributes.bits |= AttributeSet::kColour;
  mesh.vertex_attributes.resize(mesh.positions.size());
  for (VertexAttributes& attributes : mesh.vertex_attributes)
    attributes.colour = attributes.material == 0 ? glm::u8vec4(0, 0, 0, 255) : glm::u8vec4(255);
  EXPECT_EQ(lostAt(300, test::nodeOf(mesh)), 0);
}

TEST(LostDetail, isZeroForASingleStrayPoint) {
  NodeMesh stray = wall(AttributeSet::kColour, [](glm::vec2, VertexAttributes&) {});
  stray.wedge_attributes[stray.wedge_attributes.size() / 2 + kWallCells / 2].colour =
      glm::u8vec4(0, 0, 0, 255);
  EXPECT_EQ(lostAt(4000, stray), 0);
}

}  // namespace
}  // namespace lode::ingest
