#include "server/ingest/simplify/collapse_mesh.h"

#include <numeric>

#include <gtest/gtest.h>

#include "server/ingest/simplify/collapse_check.h"
#include "tests/support/node_meshes.h"

namespace lode::ingest {
namespace {

/// Merges random edges of a mesh and records where each position went.
class RandomMerges {
 public:
  RandomMerges(const NodeMesh& input, uint32_t seed)
      : input_(input),
        mesh_(NodeMesh(input), 0),
        around_(mesh_),
        check_(mesh_),
        map_(input.positions.size()),
        random_(seed) {
    std::iota(map_.begin(), map_.end(), 0u);
  }

  bool step() {
    const std::vector<CollapseMesh::Edge> edges = test::edgesOf(mesh_);
    if (edges.empty()) return false;
    const CollapseMesh::Edge edge = edges[random_() % edges.size()];
    around_.gather(edge.u, edge.v);
    const bool folds = check_.check(around_, mesh_.point(edge.v), {.link_condition = false}).folds;
    mesh_.merge(edge.v, edge.u, mesh_.point(edge.v), 0);
    if (folds) mesh_.removeFolds(edge.v);
    for (uint32_t& position : map_)
      if (position == edge.u) position = edge.v;
    return true;
  }

  std::set<test::PositionEdge> oddEdges() const {
    std::vector<uint32_t> new_position;
    return test::oddEdges(mesh_.compact(new_position));
  }

  /// Image of the input's odd edges under the recorded map.
  std::set<test::PositionEdge> image() const {
    std::set<test::PositionEdge> odd;
    const auto codeOf = [&](uint32_t i) { return input_.positions[map_[i]].value; };
    for (const glm::u32vec3 t : input_.triangles) {
      for (int k = 0; k < 3; ++k) {
        const uint64_t a = codeOf(input_.wedge_position[t[k]]);
        const uint64_t b = codeOf(input_.wedge_position[t[(k + 1) % 3]]);
        const test::PositionEdge edge{std::min(a, b), std::max(a, b)};
        if (a != b && !odd.erase(edge)) odd.insert(edge);
      }
    }
    return odd;
  }

 private:
  const NodeMesh& input_;
  CollapseMesh mesh_;
  EdgeSurroundings around_;
  CollapseCheck check_;
  std::vector<uint32_t> map_;
  std::mt19937 random_;
};

TEST(CollapseMesh, keepsOddEdgesEqualToTheImageOfTheInputs) {
  for (uint32_t seed = 1; seed <= 12; ++seed) {
    test::MeshOptions options;
    options.attributes.bits = seed % 2 ? AttributeSet::kAll : 0;
    const NodeMesh input = seed % 3 == 0   ? test::makeTangle(30, 60, seed)
                           : seed % 3 == 1 ? test::nodeOf(test::makeGrid(7, 6, options))
                                           : test::nodeOf(test::makeSphere(8, 6, options));
    RandomMerges merges(input, seed);
    do ASSERT_EQ(merges.oddEdges(), merges.image()) << "seed " << seed;
    while (merges.step());
  }
}

TEST(CollapseMesh, givesEachEdgeOnceWithItsUses) {
  NodeMesh book;  // three pages on one spine
  for (uint32_t i = 0; i < 5; ++i) book.positions.push_back(packPosition({i, i * i, 1}));
  book.lca_depth.assign(5, kNeverLocked);
  book.wedge_position = {0, 1, 2, 3, 4};
  book.triangles = {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}};
  const CollapseMesh mesh(std::move(book), 0);
  const std::vector<CollapseMesh::Edge> edges = test::edgesOf(mesh);
  ASSERT_EQ(edges.size(), 7u);
  for (const CollapseMesh::Edge& edge : edges) EXPECT_EQ(edge.uses, edge.u == 0 && edge.v == 1 ? 3u : 1u);
}

TEST(CollapseMesh, knowsBoundariesSeamsAndTheirCorners) {
  test::MeshOptions options;
  options.attributes.bits = AttributeSet::kMaterial;
  const Mesh sheet = test::makeGrid(8, 6, options);
  CollapseMesh mesh(test::nodeOf(sheet), 0);
  mesh.classifyPositions([](const auto&) {});
  std::array<size_t, 5> counts{};
  for (const CollapsePosition& position : mesh.positions) ++counts[static_cast<size_t>(position.kind)];
  EXPECT_EQ(counts[static_cast<size_t>(PositionKind::kSmooth)], 6u * 5);
  EXPECT_EQ(counts[static_cast<size_t>(PositionKind::kSeam)], 5u);
  EXPECT_EQ(counts[static_cast<size_t>(PositionKind::kSeamCorner)], 0u);
  EXPECT_EQ(counts[static_cast<size_t>(PositionKind::kBoundary)], 26u);
  EXPECT_EQ(counts[static_cast<size_t>(PositionKind::kBoundaryCorner)], 2u);
}

TEST(CollapseMesh, mixesAttributesByShareAndCopiesAtTheEnds) {
  const auto coloured = [](uint8_t red) { return VertexAttributes{.colour = {red, 0, 0, 255}}; };
  AttributeSet colour;
  colour.bits = AttributeSet::kColour;
  WedgeTable table(colour, {coloured(0), coloured(200)});
  table.mix(0, 1, 0.25);
  EXPECT_EQ(table.code(0), coloured(50));
  table.mix(0, 1, 0);
  EXPECT_EQ(table.code(0), coloured(50));
  table.mix(0, 1, 1);
  EXPECT_EQ(table.code(0), coloured(200));
}

}  // namespace
}  // namespace lode::ingest
