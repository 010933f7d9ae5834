#include "server/store/export.h"

#include <array>
#include <tuple>

#include "server/store/open_edges.h"
#include "tests/unit/store/store_files.h"

namespace lode::store {
namespace {

constexpr AttributeSet kEverything{AttributeSet::kNormal | AttributeSet::kColour | AttributeSet::kTexture |
                                   AttributeSet::kMaterial};

using Corner = std::tuple<uint64_t, uint16_t, uint16_t, uint32_t, uint32_t>;

/// A mesh as a sorted list of triangles by value, the smallest corner first.
std::vector<std::array<Corner, 3>> byValue(const Mesh& mesh) {
  const auto corner = [&](uint32_t i) -> Corner {
    if (mesh.vertex_attributes.empty()) return {mesh.positions[i].value, 0, 0, 0, 0};
    const VertexAttributes& a = mesh.vertex_attributes[i];
    return {mesh.positions[i].value, a.normal, a.material,
            a.colour.r | a.colour.g << 8 | a.colour.b << 16 | uint32_t{a.colour.a} << 24,
            a.texture.x | uint32_t{a.texture.y} << 16};
  };
  std::vector<std::array<Corner, 3>> triangles;
  for (const glm::u32vec3 t : mesh.triangles) {
    std::array<Corner, 3> corners{corner(t.x), corner(t.y), corner(t.z)};
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    triangles.push_back(corners);
  }
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

TEST(Export, givesTheOriginalMeshForTheLeaves) {
  const test::WorkFolder folder;
  const Mesh original = test::makeSphere(24, 16, {.attributes = kEverything, .extent = 4000});
  test::SyntheticModel model = test::makeModel(original);
  test::writeStore(folder / "a.lode", model);
  const Reader reader(folder / "a.lode");
  const NodeTree tree(reader.nodes());
  const Mesh exported = assembleCut(reader, leafCut(tree));
  EXPECT_EQ(byValue(exported), byValue(original));
  EXPECT_EQ(exported.positions.size(), original.positions.size());
}

TEST(Export, hasNoVertexTwice) {
  const test::WorkFolder folder;
  test::SyntheticModel model = test::closedModel(kEverything);
  test::writeStore(folder / "a.lode", model);
  const Reader reader(folder / "a.lode");
  const NodeTree tree(reader.nodes());
  for (uint64_t seed = 0; seed < 10; ++seed) {
    const Mesh mesh = assembleCut(reader, randomCut(tree, seed));
    std::vector<std::pair<uint64_t, std::string>> vertices;
    for (size_t i = 0; i < mesh.positions.size(); ++i)
      vertices.emplace_back(
          mesh.positions[i].value,
          std::string(reinterpret_cast<const char*>(&mesh.vertex_attributes[i]), sizeof(VertexAttributes)));
    std::sort(vertices.begin(), vertices.end());
    EXPECT_EQ(std::adjacent_find(vertices.begin(), vertices.end()), vertices.end());
  }
}

TEST(Export, isClosedForAnyCutOfAClosedModel) {
  const test::WorkFolder folder;
  test::SyntheticModel model = test::closedModel(kEverything);
  test::writeStore(folder / "a.lode", model);
  const Reader reader(folder / "a.lode");
  const NodeTree tree(reader.nodes());
  for (uint64_t seed = 0; seed < 20; ++seed) {
    OpenEdges edges;
    edges.add(assembleCut(reader, randomCut(tree, seed)));
    EXPECT_TRUE(edges.edges().empty()) << seed;
  }
}

TEST(Export, namesFileAndNodeOfADamagedPayload) {
  const test::WorkFolder folder;
  test::SyntheticModel model = test::smallModel();
  Writer writer(folder / "a.lode");
  for (Node& node : model.nodes)
    for (Lod& lod : node.lods)
      if (lod.triangles != 0)
        lod.payload = writer.addBlob(std::vector<std::byte>(50, static_cast<std::byte>(node.key.value)));
  writer.finish(model.summary, model.nodes);
  const Reader reader(folder / "a.lode");
  const NodeTree tree(reader.nodes());
  const std::string message = test::messageOf([&] { assembleCut(reader, leafCut(tree)); });
  EXPECT_NE(message.find("a.lode: node root/"), std::string::npos) << message;
}

}  // namespace
}  // namespace lode::store
