#include <algorithm>
#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "common/codec/octahedral.h"
#include "common/codec/surface_normals.h"
#include "common/image/image.h"
#include "server/tiles/tile_content.h"
#include "tests/support/test_meshes.h"
#include "tests/unit/tiles/glb_file.h"

namespace lode::tiles {
namespace {

using test::GlbFile;
using test::ViewedStream;

constexpr double kStep = 0.375;
constexpr uint8_t kComputedNormals = AttributeSet::kNormal | AttributeSet::kComputedNormal;

store::DecodedLod lodOf(const Mesh& mesh) {
  const EncodedPayload payload = encodePayload(mesh, kStep);
  store::DecodedLod lod{payload.bytes, {}, {}};
  lod.mesh = decodePayload(
      payload.bytes, kStep,
      {static_cast<uint32_t>(mesh.triangles.size()), payload.vertices, mesh.attributes, test::boxOf(mesh)},
      &lod.ids);
  return lod;
}

/// Returns a sphere whose computed normals follow from its triangles, so that its payload leaves them out.
Mesh sphereWithComputedNormals(uint8_t other_attributes = 0) {
  const auto attributes = static_cast<uint8_t>(kComputedNormals | other_attributes);
  Mesh mesh = test::makeSphere(24, 16, {.attributes = {attributes}, .extent = 4000});
  const std::vector<uint16_t> normals = surfaceNormals(mesh);
  for (size_t v = 0; v < normals.size(); ++v) mesh.vertex_attributes[v].normal = normals[v];
  return mesh;
}

Mesh sphereWith(uint8_t attributes) {
  return test::makeSphere(24, 16, {.attributes = {attributes}, .extent = 4000, .origin = {7, 800, 90000}});
}

GlbFile glbOf(const Mesh& mesh) { return test::parseGlb(encodeGlb(plainContent(lodOf(mesh), kStep))); }

TEST(Glb, containsThePayloadUnchanged) {
  for (const uint8_t attributes : {uint8_t{0}, AttributeSet::kNormal, AttributeSet::kTexture}) {
    const store::DecodedLod lod = lodOf(sphereWith(attributes));
    const GlbFile glb = test::parseGlb(encodeGlb(plainContent(lod, kStep)));
    EXPECT_TRUE(std::ranges::equal(glb.view(0), lod.payload)) << int{attributes};
  }
}

TEST(Glb, refersToAttributesByTheIdsOfTheStream) {
  EXPECT_EQ(glbOf(sphereWith(AttributeSet::kNormal)).idsInStream(),
            nlohmann::json({{"POSITION", 0}, {"NORMAL", 1}}));
  EXPECT_EQ(glbOf(sphereWith(AttributeSet::kNormal | AttributeSet::kColour)).idsInStream(),
            nlohmann::json({{"POSITION", 0}, {"NORMAL", 1}, {"COLOR_0", 2}}));
  EXPECT_EQ(glbOf(sphereWithComputedNormals()).idsInStream(), nlohmann::json({{"POSITION", 0}}));
}

TEST(StreamIds, shiftWhereNormalsAreLeftOut) {
  constexpr uint8_t kOthers = AttributeSet::kColour | AttributeSet::kTexture;
  const StreamIds with = lodOf(sphereWith(AttributeSet::kNormal | kOthers)).ids;
  EXPECT_EQ(with, (StreamIds{0, 1, 2, 3, {}, 3}));
  const StreamIds without = lodOf(sphereWithComputedNormals(kOthers)).ids;
  EXPECT_EQ(without, (StreamIds{0, {}, 1, 2, {}, 3}));
}

TEST(Glb, countsTheVerticesAndIndicesOfTheStream) {
  for (const uint8_t attributes : {uint8_t{0}, kComputedNormals, AttributeSet::kColour}) {
    const GlbFile glb = glbOf(sphereWith(attributes));
    const ViewedStream stream(glb);
    EXPECT_EQ(glb.accessor("POSITION")["count"], stream.mesh().num_points());
    EXPECT_EQ(glb.accessor("NORMAL")["count"], stream.mesh().num_points());
    EXPECT_EQ(glb.json["accessors"][glb.primitive()["indices"].get<size_t>()]["count"],
              3 * stream.mesh().num_faces());
  }
}

/// Returns the corners of all triangles as floats, sorted.
std::vector<std::array<float, 9>> cornersOf(const ViewedStream& stream, uint32_t id) {
  std::vector<std::array<float, 9>> all;
  for (draco::FaceIndex f(0); f < stream.mesh().num_faces(); ++f) {
    std::array<std::vector<float>, 3> corners;
    for (int k = 0; k < 3; ++k) corners[k] = stream.floats(id, stream.mesh().face(f)[k].value());
    std::ranges::rotate(corners, std::ranges::min_element(corners));
    std::array<float, 9> flat{};
    for (int i = 0; i < 9; ++i) flat[i] = corners[i / 3][i % 3];
    all.push_back(flat);
  }
  std::ranges::sort(all);
  return all;
}

TEST(Glb, hasTheSameTrianglesToTheLastBitAfterColoursAreEncodedAgain) {
  const store::DecodedLod lod = lodOf(sphereWith(AttributeSet::kNormal | AttributeSet::kColour));
  const GlbFile stored{{{"bufferViews", {{{"byteLength", lod.payload.size()}}}}}, lod.payload};
  const GlbFile glb = test::parseGlb(encodeGlb(plainContent(lod, kStep)));
  EXPECT_FALSE(std::ranges::equal(glb.view(0), lod.payload));
  EXPECT_EQ(cornersOf(ViewedStream(glb), 0), cornersOf(ViewedStream(stored), 0));
  EXPECT_EQ(cornersOf(ViewedStream(glb), 1), cornersOf(ViewedStream(stored), 1));  // normals
}

TEST(Glb, hasExactBounds) {
  const GlbFile glb = glbOf(sphereWith(0));
  const ViewedStream stream(glb);
  std::vector<float> least = stream.floats(0, 0), most = least;
  for (uint32_t v = 0; v < stream.mesh().num_points(); ++v)
    for (int k = 0; k < 3; ++k) {
      least[k] = std::min(least[k], stream.floats(0, v)[k]);
      most[k] = std::max(most[k], stream.floats(0, v)[k]);
    }
  EXPECT_EQ(glb.accessor("POSITION")["min"].get<std::vector<float>>(), least);
  EXPECT_EQ(glb.accessor("POSITION")["max"].get<std::vector<float>>(), most);
}

void expectNormalsBesideTheStream(const Mesh& mesh) {
  const GlbFile glb = glbOf(mesh);
  const auto& accessor = glb.accessor("NORMAL");
  EXPECT_EQ(accessor["componentType"], 5120);
  EXPECT_EQ(accessor["normalized"], true);
  EXPECT_EQ(glb.json["bufferViews"][1]["byteStride"], 4);
  EXPECT_EQ(glb.json["bufferViews"][1]["byteOffset"].get<size_t>() % 4, 0u);
  EXPECT_EQ(glb.json["extensionsRequired"],
            nlohmann::json({"KHR_draco_mesh_compression", "KHR_mesh_quantization"}));
  const std::vector<uint16_t> wanted = surfaceNormals(lodOf(mesh).mesh);  // in the stream's order
  const auto bytes = glb.view(1);
  ASSERT_EQ(bytes.size(), 4 * wanted.size());
  for (size_t v = 0; v < wanted.size(); ++v) {
    const glm::vec3 found(static_cast<int8_t>(bytes[4 * v]), static_cast<int8_t>(bytes[4 * v + 1]),
                          static_cast<int8_t>(bytes[4 * v + 2]));
    EXPECT_LT(glm::length(found / 127.f - decodeOctahedral(wanted[v])), 0.007f);
  }
}

TEST(Glb, hasNormalsBesideAStreamThatLeavesThemOut) {
  expectNormalsBesideTheStream(sphereWithComputedNormals());
}

TEST(Glb, hasNormalsEvenIfTheModelHasNone) { expectNormalsBesideTheStream(sphereWith(0)); }

TEST(Glb, hasColoursInLinearLight) {
  for (const Mesh& mesh :
       {sphereWith(AttributeSet::kColour), sphereWithComputedNormals(AttributeSet::kColour)}) {
    const GlbFile glb = glbOf(mesh);
    EXPECT_EQ(glb.accessor("COLOR_0")["componentType"], 5126);
    EXPECT_EQ(glb.accessor("COLOR_0")["type"], "VEC3");
    const ViewedStream stream(glb);
    std::map<std::vector<float>, glm::u8vec4> colours;  // by position
    for (size_t v = 0; v < mesh.positions.size(); ++v) {
      const glm::vec3 p = glm::vec3(unpackPosition(mesh.positions[v])) * static_cast<float>(kStep);
      colours[{p.x, p.y, p.z}] = mesh.vertex_attributes[v].colour;
    }
    for (uint32_t v = 0; v < stream.mesh().num_points(); ++v)
      for (int k = 0; k < 3; ++k)
        EXPECT_NEAR(stream.floats(glb.idsInStream()["COLOR_0"], v)[k],
                    linearOf(colours.at(stream.floats(0, v))[k]), 0.5001 / 1023);
    EXPECT_EQ(glb.idsInStream()["NORMAL"], 1);
  }
}

TEST(Glb, isOpaqueLikeTheClientsPictureWhateverTheAlpha) {
  for (const int alpha : {0, 100, 255}) {
    Mesh mesh = sphereWith(AttributeSet::kColour | AttributeSet::kAlpha);
    for (size_t v = 0; v < mesh.vertex_attributes.size(); ++v)
      mesh.vertex_attributes[v].colour.a = static_cast<uint8_t>(v % 2 == 0 ? alpha : 200);
    const GlbFile glb = glbOf(mesh);
    EXPECT_EQ(glb.accessor("COLOR_0")["type"], "VEC3");
    EXPECT_FALSE(glb.json["materials"][0].contains("alphaMode"));
  }
}

TEST(Glb, turnsTheModelSoThatViewersTurnItBack) {
  const auto matrix = glbOf(sphereWith(0)).json["nodes"][0]["matrix"].get<std::vector<float>>();
  const auto apply = [&](glm::vec3 p) {  // column-major
    return glm::vec3(matrix[0] * p.x + matrix[4] * p.y + matrix[8] * p.z,
                     matrix[1] * p.x + matrix[5] * p.y + matrix[9] * p.z,
                     matrix[2] * p.x + matrix[6] * p.y + matrix[10] * p.z);
  };
  const glm::vec3 in_gltf = apply({1, 2, 3});
  EXPECT_EQ(glm::vec3(in_gltf.x, -in_gltf.z, in_gltf.y), glm::vec3(1, 2, 3));  // y up to z up
}

TEST(Glb, isTheSameEveryTime) {
  const store::DecodedLod lod = lodOf(sphereWith(AttributeSet::kNormal | AttributeSet::kColour));
  EXPECT_EQ(encodeGlb(plainContent(lod, kStep)), encodeGlb(plainContent(lod, kStep)));
}

}  // namespace
}  // namespace lode::tiles
