// Checks the build's invariants on real models, by reading the stores with the libraries.

#include <algorithm>
#include <array>
#include <optional>
#include <set>
#include <unordered_map>
#include <utility>
#include <vector>

#include "models.h"
#include "server/ingest/ply/ply_reader.h"
#include "server/store/cut.h"
#include "server/store/export.h"
#include "server/store/node_tree.h"
#include "server/store/open_edges.h"
#include "server/store/reader.h"
#include "server/store/verify.h"

namespace lode::test {
namespace {

constexpr unsigned kRandomCuts = 20;

class Invariants : public testing::TestWithParam<Model> {
 protected:
  void SetUp() override {
    LODE_REQUIRE_MODEL(GetParam());
    reader_.emplace(GetParam().store());
    tree_.emplace(reader_->nodes());
  }

  std::vector<store::OpenEdge> openEdges(const store::Cut& cut) const {
    store::OpenEdges open;
    for (const store::CutItem& item : cut.items) {
      open.add(store::readLod(*reader_, tree_->node(item.node), item.lod));
    }
    return open.edges();
  }

  std::optional<store::Reader> reader_;
  std::optional<store::NodeTree> tree_;
};

using Corners = std::array<uint64_t, 3>;

/// Returns the corners of a triangle, rotated so that the smallest comes first.
Corners canonical(Corners corners) {
  std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
  return corners;
}

/// Returns the input's triangles with three distinct lattice corners, sorted. Requires a model without
/// polygons.
std::vector<Corners> inputTriangles(const Model& model, const Lattice& lattice) {
  ingest::PlyReader reader(model.input, {});
  std::vector<PositionCode> positions;
  std::vector<Corners> triangles;
  reader.read(
      [&](uint64_t, std::span<const ingest::PlyVertex> vertices) {
        for (const auto& vertex : vertices) positions.push_back(packPosition(lattice.snap(vertex.position)));
      },
      [&](const ingest::PlyFaces& faces) {
        ASSERT_EQ(faces.corners.size(), 3 * faces.corner_counts.size());
        for (size_t i = 0; i < faces.corners.size(); i += 3) {
          const Corners corners{positions[faces.corners[i]].value, positions[faces.corners[i + 1]].value,
                                positions[faces.corners[i + 2]].value};
          if (corners[0] != corners[1] && corners[1] != corners[2] && corners[2] != corners[0]) {
            triangles.push_back(canonical(corners));
          }
        }
      });
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

TEST_P(Invariants, I1EveryInputTriangleIsInExactlyOneLeaf) {
  std::vector<Corners> stored;
  for (const Node& node : reader_->nodes()) {
    if (!node.isLeaf()) continue;
    const Mesh mesh = store::readLod(*reader_, node, 0);
    for (const glm::u32vec3& t : mesh.triangles) {
      stored.push_back(
          canonical({mesh.positions[t.x].value, mesh.positions[t.y].value, mesh.positions[t.z].value}));
    }
  }
  std::sort(stored.begin(), stored.end());
  const std::vector<Corners> input = inputTriangles(GetParam(), reader_->summary().lattice);
  EXPECT_EQ(stored.size(), reader_->summary().triangles);
  EXPECT_TRUE(stored == input) << stored.size() << " stored, " << input.size() << " in the input";
}

TEST_P(Invariants, I2RandomCutsOfClosedModelsHaveNoOpenEdges) {
  if (!GetParam().is_closed) GTEST_SKIP() << GetParam().name << " has boundaries";
  EXPECT_TRUE(openEdges(store::leafCut(*tree_)).empty());
  for (uint64_t seed = 1; seed <= kRandomCuts; ++seed) {
    const store::Cut cut = store::randomCut(*tree_, seed);
    ASSERT_TRUE(store::coversExactlyOnce(*tree_, cut.items));
    EXPECT_TRUE(openEdges(cut).empty()) << "seed " << seed << ": " << openEdges(cut).size();
  }
}

/// Counts edges that more than two triangles use.
size_t crowdedEdges(const store::Reader& reader, const store::NodeTree& tree, const store::Cut& cut) {
  std::vector<std::pair<uint64_t, uint64_t>> edges;
  for (const store::CutItem& item : cut.items) {
    const Mesh mesh = store::readLod(reader, tree.node(item.node), item.lod);
    for (const glm::u32vec3& t : mesh.triangles) {
      for (int k = 0; k < 3; ++k) {
        const uint64_t from = mesh.positions[t[k]].value, to = mesh.positions[t[(k + 1) % 3]].value;
        edges.emplace_back(std::min(from, to), std::max(from, to));
      }
    }
  }
  std::sort(edges.begin(), edges.end());
  size_t crowded = 0;
  for (size_t i = 2; i < edges.size(); ++i) crowded += edges[i] == edges[i - 2];
  return crowded;
}

/// Excludes the root, because the root of a porous model has too few triangles for all handles.
TEST_P(Invariants, randomCutsOfManifoldsHaveNoEdgeOfMoreThanTwoTriangles) {
  if (!GetParam().is_closed) GTEST_SKIP() << GetParam().name << " has boundaries";
  ASSERT_EQ(crowdedEdges(*reader_, *tree_, store::leafCut(*tree_)), 0u);
  for (uint64_t seed = 1; seed <= kRandomCuts; ++seed) {
    const store::Cut cut = store::randomCut(*tree_, seed);
    if (cut.items.size() == 1) continue;
    EXPECT_EQ(crowdedEdges(*reader_, *tree_, cut), 0u) << "seed " << seed;
  }
}

TEST_P(Invariants, I2OpenEdgesOfRandomCutsLieWithinTheStoredErrorOfTheBoundaries) {
  const store::VerifyReport report = store::verifyStore(GetParam().store(), {.random_cuts = kRandomCuts});
  EXPECT_EQ(report.cuts, kRandomCuts);
  EXPECT_EQ(report.open_edges == 0, GetParam().is_closed);
}

TEST_P(Invariants, I3ErrorsNeverFallTowardsCoarser) {
  for (uint32_t n = 0; n < tree_->nodes().size(); ++n) {
    const Node& node = tree_->node(n);
    for (size_t r = 1; r < node.lods.size(); ++r) {
      EXPECT_GE(node.lods[r].error_model, node.lods[r - 1].error_model);
    }
    for (uint32_t c = 0; c < tree_->childCount(n); ++c) {
      EXPECT_GE(node.lods[0].error_model, tree_->node(tree_->firstChild(n) + c).sourceLod().error_model);
    }
  }
}

/// Returns the attributes at each position that has only one wedge.
std::unordered_map<uint64_t, VertexAttributes> singleWedges(const Mesh& mesh) {
  std::unordered_map<uint64_t, VertexAttributes> single;
  std::unordered_map<uint64_t, uint32_t> wedges;
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    const auto [at, is_new] = single.emplace(mesh.positions[v].value, mesh.vertex_attributes[v]);
    if (is_new || !(at->second == mesh.vertex_attributes[v])) ++wedges[mesh.positions[v].value];
  }
  for (const auto& [position, count] : wedges) {
    if (count > 1) single.erase(position);
  }
  return single;
}

/// Returns the computed normals of the original surface at each position. A position on a crease has several.
std::unordered_map<uint64_t, std::set<uint16_t>> originalNormals(const store::Reader& reader) {
  std::unordered_map<uint64_t, std::set<uint16_t>> normals;
  for (const Node& node : reader.nodes()) {
    if (!node.isLeaf()) continue;
    const Mesh mesh = store::readLod(reader, node, 0);
    for (size_t v = 0; v < mesh.positions.size(); ++v)
      normals[mesh.positions[v].value].insert(mesh.vertex_attributes[v].normal);
  }
  return normals;
}

/// If two nodes each contain one side of a crease, each has one of the original normals there.
TEST_P(Invariants, I5PartsOfACutHaveTheSameAttributesAtSharedVertices) {
  std::unordered_map<uint64_t, std::set<uint16_t>> original;
  if (reader_->summary().attributes.has(AttributeSet::kComputedNormal)) original = originalNormals(*reader_);
  uint64_t shared = 0;
  for (uint64_t seed = 1; seed <= kRandomCuts; ++seed) {
    std::unordered_map<uint64_t, VertexAttributes> seen;
    for (const store::CutItem& item : store::randomCut(*tree_, seed).items) {
      for (auto [position, attributes] :
           singleWedges(store::readLod(*reader_, tree_->node(item.node), item.lod))) {
        const auto [at, is_new] = seen.emplace(position, attributes);
        shared += !is_new;
        if (const auto& known = original[position]; !is_new && known.size() > 1) {
          ASSERT_TRUE(known.contains(at->second.normal) && known.contains(attributes.normal))
              << "seed " << seed;
          attributes.normal = at->second.normal;
        }
        ASSERT_EQ(at->second, attributes) << "seed " << seed;
      }
    }
  }
  EXPECT_GT(shared, 0u);
}

INSTANTIATE_TEST_SUITE_P(Of, Invariants, testing::ValuesIn(models()), nameOf);

}  // namespace
}  // namespace lode::test
