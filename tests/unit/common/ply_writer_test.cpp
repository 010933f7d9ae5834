#include "common/io/ply_writer.h"

#include <cstring>
#include <string>

#include <gtest/gtest.h>

#include "common/codec/octahedral.h"
#include "tests/support/bytes.h"
#include "tests/support/test_meshes.h"
#include "tests/support/work_folder.h"
#include "tests/unit/common/wide_triangle.h"

namespace lode {
namespace {

class PlyWriter : public testing::Test {
 protected:
  // Writes a mesh, and splits the file at the end of its header.
  void write(const Mesh& mesh, const Lattice& lattice, const TextureSet& textures = {}) {
    writePly(folder_ / "mesh.ply", mesh, lattice, textures);
    const std::string all = test::readBytes(folder_ / "mesh.ply");
    const size_t end = all.find("end_header\n") + 11;
    header_ = all.substr(0, end);
    body_ = all.substr(end);
  }

  template <typename T>
  T next() {
    T value{};
    EXPECT_LE(sizeof(T), body_.size());
    std::memcpy(&value, body_.data(), std::min(sizeof(T), body_.size()));
    body_.erase(0, sizeof(T));
    return value;
  }

  test::WorkFolder folder_;
  std::string header_, body_;
};

TEST_F(PlyWriter, writesFloatsWhereTheyAreExact) {
  write(wideTriangle(), {{-8, 0, 16}, 0.5});
  EXPECT_EQ(header_,
            "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
            "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n");
  for (const float expected : {-8.0f, 0.5f, 17.0f, -6.0f, 2.5f, 19.0f}) EXPECT_EQ(next<float>(), expected);
  for (const double origin : {-8, 0, 16}) EXPECT_EQ(double(next<float>()), origin + kMaxLattice * 0.5);
  EXPECT_EQ(next<uint8_t>(), 3);
  for (const int expected : {0, 2, 1}) EXPECT_EQ(next<int32_t>(), expected);
  EXPECT_TRUE(body_.empty());
}

TEST_F(PlyWriter, writesDoublesWhereFloatsWouldRound) {
  write(wideTriangle(), {{5000000, 400000, 0}, 0x1p-10});
  EXPECT_NE(header_.find("property double x\nproperty double y\nproperty double z\n"), std::string::npos);
  for (const double expected : {5000000.0, 400000 + 0x1p-10, 0x1p-9}) EXPECT_EQ(next<double>(), expected);
  EXPECT_EQ(next<double>(), 5000000 + 0x1p-8);
}

TEST_F(PlyWriter, writesEveryAttribute) {
  test::MeshOptions options;
  options.attributes.bits = AttributeSet::kAll;
  const Mesh mesh = test::makeGrid(4, 3, options);
  const Lattice lattice{{0, 0, 0}, 0.25};
  write(mesh, lattice);
  EXPECT_NE(header_.find("property float nx\nproperty float ny\nproperty float nz\nproperty uchar red\n"
                         "property uchar green\nproperty uchar blue\nproperty uchar alpha\nproperty float s\n"
                         "property float t\nelement face 24\n"),
            std::string::npos)
      << header_;
  EXPECT_NE(header_.find("vertex_indices\nproperty int texnumber\nend_header\n"), std::string::npos);
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    const VertexAttributes& attributes = mesh.vertex_attributes[i];
    const glm::dvec3 p = lattice.toWorld(unpackPosition(mesh.positions[i]));
    for (int axis = 0; axis < 3; ++axis) ASSERT_EQ(double(next<float>()), p[axis]);
    const auto nx = next<float>(), ny = next<float>(), nz = next<float>();
    ASSERT_EQ(encodeOctahedral({nx, ny, nz}), attributes.normal);
    for (int channel = 0; channel < 4; ++channel) ASSERT_EQ(next<uint8_t>(), attributes.colour[channel]);
    for (int axis = 0; axis < 2; ++axis) ASSERT_EQ(next<float>() / kTextureStep, attributes.texture[axis]);
  }
  for (const glm::u32vec3 triangle : mesh.triangles) {
    ASSERT_EQ(next<uint8_t>(), 3);
    for (int corner = 0; corner < 3; ++corner) ASSERT_EQ(next<uint32_t>(), triangle[corner]);
    ASSERT_EQ(next<uint32_t>(), mesh.vertex_attributes[triangle.x].material);
  }
  EXPECT_TRUE(body_.empty());
}

TEST_F(PlyWriter, writesTrueTextureCoordinatesAndTheNamesOfTextures) {
  Mesh mesh = wideTriangle();
  mesh.attributes.bits = AttributeSet::kTexture;
  mesh.vertex_attributes.resize(3);
  mesh.vertex_attributes[0].texture = {0, 65535};
  mesh.vertex_attributes[1].texture = {1, 2};
  TextureSet textures;
  textures.uv_origin = {-3, 100};
  textures.uv_scale_exponent = 3;
  textures.textures = {{"two words.png", 4, 4, {}}, {"missing.png", 0, 0, {}}};
  write(mesh, {{-8, 0, 16}, 0.5}, textures);
  EXPECT_NE(header_.find("1.0\ncomment TextureFile two words.png\ncomment TextureFile missing.png\nelement"),
            std::string::npos)
      << header_;
  for (const glm::dvec2 expected : {glm::dvec2(-3, 100 + 65535 * 0x1p-13), {-3 + 0x1p-13, 100 + 0x1p-12}}) {
    for (int axis = 0; axis < 3; ++axis) next<float>();
    EXPECT_EQ(next<float>(), static_cast<float>(expected.x));
    EXPECT_EQ(next<float>(), static_cast<float>(expected.y));
  }
}

TEST_F(PlyWriter, writesMinusOneForNoTexture) {
  Mesh mesh = wideTriangle();
  mesh.attributes.bits = AttributeSet::kMaterial;
  mesh.vertex_attributes.resize(3);
  for (VertexAttributes& vertex : mesh.vertex_attributes) vertex.material = kNoMaterial;
  write(mesh, {});
  body_.erase(0, body_.size() - sizeof(int32_t));
  EXPECT_EQ(next<int32_t>(), -1);
}

TEST_F(PlyWriter, writesColourWithoutAlpha) {
  test::MeshOptions options;
  options.attributes.bits = AttributeSet::kColour;
  write(test::makeGrid(1, 1, options), {});
  EXPECT_EQ(header_.find("alpha"), std::string::npos);
  EXPECT_EQ(body_.size(), 4 * 15 + 2 * 13u);
}

TEST_F(PlyWriter, writesAMeshWithoutTriangles) {
  write({}, {});
  EXPECT_NE(header_.find("element vertex 0\n"), std::string::npos);
  EXPECT_TRUE(body_.empty());
}

}  // namespace
}  // namespace lode
