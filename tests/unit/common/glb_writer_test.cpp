#include "common/io/glb_writer.h"

#include <cmath>
#include <cstring>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "common/codec/octahedral.h"
#include "common/error.h"
#include "tests/support/bytes.h"
#include "tests/support/test_meshes.h"
#include "tests/support/work_folder.h"
#include "tests/unit/common/wide_triangle.h"

namespace lode {
namespace {

using Json = nlohmann::json;

/// Writes a GLB and parses it by the glTF specification.
class GlbWriter : public testing::Test {
 protected:
  void write(const Mesh& mesh, const Lattice& lattice, const ImageFiles& images = {}) {
    writeGlb(folder_ / "cut.glb", mesh, lattice, images);
    const std::string all = test::readBytes(folder_ / "cut.glb");
    ASSERT_GE(all.size(), 20u);
    EXPECT_EQ(all.substr(0, 4), "glTF");
    EXPECT_EQ(number<uint32_t>(all, 4), 2u);
    EXPECT_EQ(number<uint32_t>(all, 8), all.size());
    const uint32_t text_bytes = number<uint32_t>(all, 12);
    EXPECT_EQ(all.substr(16, 4), "JSON");
    EXPECT_EQ(text_bytes % 4, 0u);
    json_ = Json::parse(all.substr(20, text_bytes));
    EXPECT_EQ(json_["asset"]["version"], "2.0");
    if (all.size() == 20 + text_bytes) return;
    const uint32_t binary_bytes = number<uint32_t>(all, 20 + text_bytes);
    EXPECT_EQ(all.substr(24 + text_bytes, 4), std::string("BIN\0", 4));
    EXPECT_EQ(all.size(), 28 + text_bytes + binary_bytes);
    EXPECT_EQ(json_["buffers"], (Json{{{"byteLength", binary_bytes}}}));
    binary_ = all.substr(28 + text_bytes);
  }

  template <typename T>
  static T number(const std::string& bytes, size_t at) {
    T value{};
    EXPECT_LE(at + sizeof(T), bytes.size());
    if (at + sizeof(T) <= bytes.size()) std::memcpy(&value, bytes.data() + at, sizeof(T));
    return value;
  }

  /// Returns all numbers of an accessor.
  template <typename T>
  std::vector<T> numbers(const Json& accessor_number) const {
    const Json& accessor = json_["accessors"][accessor_number.get<size_t>()];
    const Json& view = json_["bufferViews"][accessor["bufferView"].get<size_t>()];
    const std::string& type = accessor["type"].get_ref<const std::string&>();
    const size_t count = accessor["count"].get<size_t>() * (type == "SCALAR" ? 1 : type.back() - '0');
    EXPECT_EQ(view["byteLength"], count * sizeof(T));
    EXPECT_EQ(view["byteOffset"].get<size_t>() % 4, 0u);
    std::vector<T> all;
    for (size_t i = 0; i < count; ++i)
      all.push_back(number<T>(binary_, view["byteOffset"].get<size_t>() + i * sizeof(T)));
    return all;
  }
  const Json& primitive(size_t number) const { return json_["meshes"][0]["primitives"][number]; }

  test::WorkFolder folder_;
  Json json_;
  std::string binary_;
};

TEST_F(GlbWriter, keepsPositionsFarFromTheOriginExactInTheNodesTranslation) {
  write(wideTriangle(), {{5000000, -400000, 0.25}, 0x1p-10});
  EXPECT_EQ(json_["nodes"][0]["translation"], (Json{5000000, -400000, 0.25}));
  const float far = kMaxLattice * 0x1p-10f;
  EXPECT_EQ(numbers<float>(primitive(0)["attributes"]["POSITION"]),
            (std::vector<float>{0, 0x1p-10f, 0x2p-10f, 0x4p-10f, 0x5p-10f, 0x6p-10f, far, far, far}));
  EXPECT_EQ(numbers<uint32_t>(primitive(0)["indices"]), (std::vector<uint32_t>{0, 2, 1}));
  const Json& accessor = json_["accessors"][primitive(0)["attributes"]["POSITION"].get<size_t>()];
  EXPECT_EQ(accessor["min"], (Json{0, 0x1p-10, 0x2p-10}));
  EXPECT_EQ(accessor["max"], (Json{far, far, far}));
}

TEST_F(GlbWriter, writesUnitNormals) {
  Mesh mesh = wideTriangle(AttributeSet::kNormal);
  mesh.vertex_attributes[1].normal = encodeOctahedral({0.6f, 0, -0.8f});
  write(mesh, {});
  const auto normals = numbers<float>(primitive(0)["attributes"]["NORMAL"]);
  ASSERT_EQ(normals.size(), 9u);
  EXPECT_NEAR(normals[3], 0.6, 1e-2);
  EXPECT_NEAR(normals[5], -0.8, 1e-2);
  for (size_t i = 0; i < 9; i += 3)
    EXPECT_NEAR(std::hypot(normals[i], normals[i + 1], normals[i + 2]), 1, 1e-5);
}

TEST_F(GlbWriter, writesColoursAsLinearLightAndAlphaAsItIs) {
  Mesh mesh = wideTriangle(AttributeSet::kColour | AttributeSet::kAlpha);
  mesh.vertex_attributes[0].colour = {0, 255, 188, 51};
  write(mesh, {});
  const Json& accessor = json_["accessors"][primitive(0)["attributes"]["COLOR_0"].get<size_t>()];
  EXPECT_EQ(accessor["normalized"], true);
  const auto colours = numbers<uint16_t>(primitive(0)["attributes"]["COLOR_0"]);
  EXPECT_EQ(colours[0], 0);
  EXPECT_EQ(colours[1], 65535);
  EXPECT_NEAR(colours[2] / 65535.0, 0.5029, 1e-4);  // from the sRGB formula
  EXPECT_EQ(colours[3], 51 * 257);
}

TEST_F(GlbWriter, blendsWhereAVertexIsNotOpaqueAndNotForTheChannelAlone) {
  Mesh mesh = wideTriangle(AttributeSet::kColour | AttributeSet::kAlpha);
  write(mesh, {});
  EXPECT_FALSE(json_["materials"][0].contains("alphaMode"));
  mesh.vertex_attributes[1].colour.a = 254;
  write(mesh, {});
  EXPECT_EQ(json_["materials"][0]["alphaMode"], "BLEND");
}

TEST_F(GlbWriter, treatsAnAllZeroAlphaAsOpaque) {
  Mesh mesh = wideTriangle(AttributeSet::kColour | AttributeSet::kAlpha);
  for (VertexAttributes& vertex : mesh.vertex_attributes) vertex.colour = {255, 255, 255, 0};
  const auto alphas = [this] {
    const auto colours = numbers<uint16_t>(primitive(0)["attributes"]["COLOR_0"]);
    return std::vector<uint16_t>{colours.at(3), colours.at(7), colours.at(11)};
  };
  write(mesh, {});
  EXPECT_FALSE(json_["materials"][0].contains("alphaMode"));
  EXPECT_EQ(alphas(), (std::vector<uint16_t>{65535, 65535, 65535}));
  mesh.vertex_attributes[1].colour.a = 1;
  write(mesh, {});
  EXPECT_EQ(json_["materials"][0]["alphaMode"], "BLEND");
  EXPECT_EQ(alphas(), (std::vector<uint16_t>{0, 257, 0}));
}

TEST_F(GlbWriter, blendsNoMaterialForAVertexOfAnother) {
  test::MeshOptions options;
  options.attributes.bits = AttributeSet::kAlpha | AttributeSet::kTexture | AttributeSet::kMaterial;
  Mesh mesh = test::makeGrid(4, 3, options);
  for (VertexAttributes& vertex : mesh.vertex_attributes) vertex.colour.a = vertex.material == 1 ? 100 : 255;
  write(mesh, {});
  EXPECT_FALSE(json_["materials"][0].contains("alphaMode"));
  EXPECT_EQ(json_["materials"][1]["alphaMode"], "BLEND");
}

TEST_F(GlbWriter, masksClearTexelsOfAnImage) {
  test::MeshOptions options;
  options.attributes.bits = AttributeSet::kTexture | AttributeSet::kMaterial;
  TextureSet textures;
  textures.textures = {{"leaves.png", 4, 4, {}}, {"wall.png", 4, 4, {}}};
  write(test::makeGrid(4, 3, options), {}, {textures, {true, false}});
  EXPECT_EQ(json_["materials"][0]["alphaMode"], "MASK");
  EXPECT_FALSE(json_["materials"][1].contains("alphaMode"));
}

TEST_F(GlbWriter, countsTextureCoordinatesFromTheImagesTop) {
  Mesh mesh = wideTriangle(AttributeSet::kTexture);
  mesh.vertex_attributes[0].texture = {16384, 49152};
  write(mesh, {});
  const auto uvs = numbers<float>(primitive(0)["attributes"]["TEXCOORD_0"]);
  EXPECT_EQ(uvs[0], 0.25f);
  EXPECT_EQ(uvs[1], 0.25f);
}

TEST_F(GlbWriter, givesEachMaterialAPrimitiveAndTheImageThatItWears) {
  test::MeshOptions options;
  options.attributes.bits = AttributeSet::kTexture | AttributeSet::kMaterial;
  const Mesh mesh = test::makeGrid(4, 3, options);
  TextureSet textures;
  textures.textures = {{"missing.png", 0, 0, {}}, {"a folder/50 %.png", 4, 4, {}}};
  write(mesh, {}, {textures, {}});
  ASSERT_EQ(json_["meshes"][0]["primitives"].size(), 2u);
  size_t triangles = 0;
  for (size_t i = 0; i < 2; ++i) {
    const auto indices = numbers<uint32_t>(primitive(i)["indices"]);
    triangles += indices.size() / 3;
    for (const uint32_t index : indices) EXPECT_EQ(mesh.vertex_attributes[index].material, i);
  }
  EXPECT_EQ(triangles, mesh.triangles.size());
  EXPECT_EQ(json_["images"], (Json{{{"uri", "a%20folder/50%20%25.png"}}}));
  const auto surface = [&](size_t i) {
    return json_["materials"][primitive(i)["material"].get<size_t>()]["pbrMetallicRoughness"];
  };
  EXPECT_FALSE(surface(0).contains("baseColorTexture"));
  EXPECT_EQ(surface(1)["baseColorTexture"]["index"], 0);
  EXPECT_EQ(json_["textures"][0]["source"], 0);
}

TEST_F(GlbWriter, writesAnEmptySceneOfAMeshWithoutTriangles) {
  write({}, {});
  EXPECT_FALSE(json_.contains("meshes"));
  EXPECT_TRUE(binary_.empty());
}

TEST_F(GlbWriter, refusesStepsThatFloatsDoNotHold) {
  EXPECT_THROW(write(wideTriangle(), {{0, 0, 0}, 0x1p-140}), Error);
  EXPECT_TRUE(folder_.contents().empty());
}

}  // namespace
}  // namespace lode
