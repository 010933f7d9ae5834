#include "common/io/obj_writer.h"

#include <string>

#include <gtest/gtest.h>

#include "common/codec/octahedral.h"
#include "tests/support/bytes.h"
#include "tests/support/test_meshes.h"
#include "tests/support/work_folder.h"

namespace lode {
namespace {

class ObjWriter : public testing::Test {
 protected:
  std::string write(const Mesh& mesh, const Lattice& lattice, const TextureSet& textures = {},
                    const std::vector<bool>& has_alpha = {}) {
    writeObj(folder_ / "cut.obj", mesh, lattice, {textures, has_alpha});
    return read("cut.obj");
  }
  std::string read(const char* name) const { return test::readBytes(folder_ / name); }

  test::WorkFolder folder_;
};

Mesh oneTriangle(uint8_t attributes = 0) {
  Mesh mesh;
  mesh.attributes.bits = attributes;
  for (const glm::uvec3 p : {glm::uvec3(0, 1, 2), glm::uvec3(4, 5, 6), glm::uvec3(7, 8, 9)})
    mesh.positions.push_back(packPosition(p));
  mesh.triangles = {{0, 2, 1}};
  if (attributes != 0) mesh.vertex_attributes.resize(3);
  return mesh;
}

TEST_F(ObjWriter, writesPositionsInFull) {
  EXPECT_EQ(write(oneTriangle(), {{5000000, 0, 16}, 0x1p-10}),
            "v 5000000 0.0009765625 16.001953125\nv 5000000.00390625 0.0048828125 16.005859375\n"
            "v 5000000.0068359375 0.0078125 16.0087890625\nf 1 3 2\n");
}

TEST_F(ObjWriter, writesColoursAfterPositionsAndIndicesOfTheOtherAttributes) {
  Mesh mesh = oneTriangle(AttributeSet::kNormal | AttributeSet::kColour | AttributeSet::kTexture);
  for (VertexAttributes& vertex : mesh.vertex_attributes) {
    vertex.normal = encodeOctahedral({0, 0, 1});
    vertex.colour = {255, 0, 51, 255};
    vertex.texture = {16384, 32768};
  }
  TextureSet textures;
  textures.uv_origin = {1, -1};
  EXPECT_EQ(write(mesh, {{0, 0, 0}, 1}, textures),
            "v 0 1 2 1 0 0.2\nv 4 5 6 1 0 0.2\nv 7 8 9 1 0 0.2\n"
            "vt 1.25 -0.5\nvt 1.25 -0.5\nvt 1.25 -0.5\n"
            "vn 0 0 1\nvn 0 0 1\nvn 0 0 1\n"
            "f 1/1/1 3/3/3 2/2/2\n");
}

TEST_F(ObjWriter, writesNormalsWithoutTextureCoordinates) {
  EXPECT_NE(write(oneTriangle(AttributeSet::kNormal), {}).find("\nf 1//1 3//3 2//2\n"), std::string::npos);
}

TEST_F(ObjWriter, putsTheImagesOfMaterialsInAFileBesideIt) {
  Mesh mesh = oneTriangle(AttributeSet::kTexture | AttributeSet::kMaterial);
  mesh.positions.insert(mesh.positions.end(), mesh.positions.begin(), mesh.positions.end());
  mesh.vertex_attributes.resize(6);
  for (size_t i = 0; i < 3; ++i) mesh.vertex_attributes[i].material = 1;
  mesh.triangles = {{0, 1, 2}, {3, 4, 5}, {2, 1, 0}};
  TextureSet textures;
  textures.textures = {{"two words.png", 4, 4, {}}, {"missing.png", 0, 0, {}}};
  const std::string text = write(mesh, {}, textures);
  EXPECT_TRUE(text.starts_with("mtllib cut.mtl\nv ")) << text;
  EXPECT_TRUE(
      text.ends_with("usemtl material_0\nf 4/4 5/5 6/6\nusemtl material_1\nf 1/1 2/2 3/3\nf 3/3 2/2 "
                     "1/1\n"))
      << text;
  EXPECT_EQ(read("cut.mtl"),
            "newmtl material_0\nKd 1 1 1\nmap_Kd two words.png\nnewmtl material_1\nKd 1 1 1\n");
}

TEST_F(ObjWriter, masksClearTexelsOfAnImage) {
  const Mesh mesh = test::makeGrid(4, 3, {.attributes = {AttributeSet::kTexture | AttributeSet::kMaterial}});
  TextureSet textures;
  textures.textures = {{"leaves.png", 4, 4, {}}, {"wall.png", 4, 4, {}}};
  write(mesh, {}, textures, {true, false});
  EXPECT_EQ(read("cut.mtl"),
            "newmtl material_0\nKd 1 1 1\nmap_Kd leaves.png\nmap_d leaves.png\n"
            "newmtl material_1\nKd 1 1 1\nmap_Kd wall.png\n");
}

TEST_F(ObjWriter, givesFacesWithoutATextureAPlainMaterial) {
  Mesh mesh = oneTriangle(AttributeSet::kTexture | AttributeSet::kMaterial);
  mesh.positions.insert(mesh.positions.end(), mesh.positions.begin(), mesh.positions.end());
  mesh.vertex_attributes.resize(6);
  for (size_t i = 0; i < 3; ++i) mesh.vertex_attributes[i].material = kNoMaterial;
  mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
  TextureSet textures;
  textures.textures = {{"a.png", 4, 4, {}}};
  EXPECT_TRUE(write(mesh, {}, textures)
                  .ends_with("usemtl material_0\nf 4/4 5/5 6/6\nusemtl material_none\nf 1/1 2/2 3/3\n"));
  EXPECT_EQ(read("cut.mtl"), "newmtl material_0\nKd 1 1 1\nmap_Kd a.png\nnewmtl material_none\nKd 1 1 1\n");
}

TEST_F(ObjWriter, writesNoMaterialsWithoutImages) {
  write(oneTriangle(AttributeSet::kTexture | AttributeSet::kMaterial), {});
  EXPECT_EQ(folder_.contents(), std::vector<std::string>{"cut.obj"});
}

TEST_F(ObjWriter, writesAMeshWithoutTriangles) { EXPECT_EQ(write({}, {}), ""); }

}  // namespace
}  // namespace lode
