#include "common/codec/corner_normals.h"

#include <algorithm>
#include <tuple>

#include <gtest/gtest.h>

#include "common/codec/draco_codec.h"
#include "common/codec/surface_normals.h"
#include "tests/support/test_meshes.h"
#include "tests/unit/common/payload_fixture.h"

namespace lode {
namespace {

constexpr uint16_t kUp = 0x7f7f, kSideways = 0x9b7f, kBack = 0xfe7f;

/// Makes four triangles around a position with three vertices. The middle vertex has two triangles that share
/// no edge.
Mesh makeThreeVerticesAtAPlace() {
  Mesh mesh;
  mesh.attributes.bits = AttributeSet::kNormal | AttributeSet::kComputedNormal;
  const auto add = [&](glm::uvec3 position, uint16_t normal) {
    mesh.positions.push_back(packPosition(position));
    mesh.vertex_attributes.push_back({.normal = normal, .material = 0});
    return static_cast<uint32_t>(mesh.positions.size()) - 1;
  };
  const glm::uvec3 place(100, 100, 100);
  const uint32_t a = add(place, kBack), b = add(place, kSideways), c = add(place, kUp);
  const auto addTriangle = [&](uint32_t vertex, glm::uvec3 second, glm::uvec3 third, uint16_t normal) {
    const uint32_t other = add(second, normal);
    mesh.triangles.emplace_back(vertex, other, add(third, normal));
  };
  addTriangle(a, {200, 100, 100}, {200, 130, 100}, kBack);
  addTriangle(b, {50, 100, 100}, {50, 80, 100}, kSideways);
  addTriangle(b, {100, 160, 100}, {100, 160, 160}, kSideways);
  addTriangle(c, {100, 40, 160}, {100, 40, 100}, kUp);
  return mesh;
}

/// Returns the positions and normals of each triangle's corners, the smallest position first.
auto cornersOf(const Mesh& mesh) {
  std::vector<std::vector<std::pair<PositionCode, uint16_t>>> corners;
  for (const glm::u32vec3 t : mesh.triangles) {
    std::vector<std::pair<PositionCode, uint16_t>> of_triangle;
    for (int k = 0; k < 3; ++k)
      of_triangle.emplace_back(mesh.positions[t[k]], mesh.vertex_attributes[t[k]].normal);
    std::ranges::rotate(of_triangle, std::ranges::min_element(of_triangle));
    corners.push_back(std::move(of_triangle));
  }
  std::ranges::sort(corners);
  return corners;
}

/// Returns the same triangles in another order. Each begins at another corner and shares no vertices.
Mesh partAll(const Mesh& mesh) {
  Mesh parted;
  parted.attributes = mesh.attributes;
  for (size_t i = mesh.triangles.size(); i-- > 0;) {
    const auto first = static_cast<uint32_t>(parted.positions.size());
    for (int k = 1; k <= 3; ++k) parted.positions.push_back(mesh.positions[mesh.triangles[i][k % 3]]);
    parted.triangles.emplace_back(first, first + 1, first + 2);
  }
  parted.vertex_attributes.resize(parted.positions.size());
  return parted;
}

TEST(CornerNormals, areFoundForSplitVertices) {
  const Mesh mesh = makeThreeVerticesAtAPlace();
  Mesh parted = partAll(mesh);
  const std::optional<std::vector<uint16_t>> normals = CornerNormals(mesh).ofVertices(parted);
  ASSERT_TRUE(normals);
  for (size_t v = 0; v < normals->size(); ++v) parted.vertex_attributes[v].normal = (*normals)[v];
  EXPECT_EQ(cornersOf(parted), cornersOf(mesh));
}

TEST(CornerNormals, areUnknownWhereEqualTrianglesHaveDifferentOnes) {
  Mesh mesh = makeThreeVerticesAtAPlace();
  const auto first = static_cast<uint32_t>(mesh.positions.size());
  for (int k = 0; k < 3; ++k) {
    mesh.positions.push_back(mesh.positions[mesh.triangles[0][k]]);
    mesh.vertex_attributes.push_back({.normal = kUp, .material = 0});
  }
  mesh.triangles.emplace_back(first, first + 1, first + 2);
  EXPECT_FALSE(CornerNormals(mesh).ofVertices(partAll(mesh)));
}

TEST(CornerNormals, surviveDracosSplitOfAVertexAmongOthers) {
  Mesh mesh = makeThreeVerticesAtAPlace();
  const std::vector<uint16_t> surface = surfaceNormals(mesh);
  for (size_t v = 0; v < surface.size(); ++v) mesh.vertex_attributes[v].normal = surface[v];
  const EncodedPayload payload = encodePayload(mesh, kStep);
  const Mesh decoded = decodePayload(payload.bytes, kStep, expectationOf(mesh, payload));
  EXPECT_EQ(cornersOf(decoded), cornersOf(mesh));

  Mesh bare = mesh;
  bare.attributes.bits = 0;
  bare.vertex_attributes.clear();
  EXPECT_LE(payload.bytes.size(), encodePayload(bare, kStep).bytes.size() + 6)
      << "normals are not left to the reader";
}

}  // namespace
}  // namespace lode
