#include "client/app/cli/cut_mesh.h"

#include <memory>
#include <vector>

#include <gtest/gtest.h>

namespace lode::app {
namespace {

constexpr AttributeSet kColoured{AttributeSet::kColour};

/// A square of four vertices, of one colour, with its left side at x.
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

/// The corners of a mesh's triangles, in their order.
std::vector<PositionCode> corners(const Mesh& mesh) {
  std::vector<PositionCode> codes;
  for (const glm::u32vec3& t : mesh.triangles)
    for (int i = 0; i < 3; ++i) codes.push_back(mesh.positions[t[i]]);
  return codes;
}

TEST(WeldCut, makesOneVertexOfThoseThatPartsShare) {
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

}  // namespace
}  // namespace lode::app
