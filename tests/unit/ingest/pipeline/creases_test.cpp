#include <map>
#include <set>

#include <gtest/gtest.h>

#include "common/codec/octahedral.h"
#include "server/ingest/pipeline/build.h"
#include "server/sample/sample.h"
#include "server/store/cut.h"
#include "server/store/export.h"
#include "server/store/node_tree.h"
#include "server/store/open_edges.h"
#include "server/store/reader.h"
#include "tests/support/bytes.h"
#include "tests/support/machine_parts.h"
#include "tests/support/work_folder.h"

namespace lode::ingest {
namespace {

using test::readBytes;

class Creases : public testing::TestWithParam<bool> {
 protected:
  void SetUp() override {
    test::writePart(GetParam() ? test::makeBoredBox(64, 8) : test::makeCube(24), folder_ / "part.ply");
  }

  std::filesystem::path built(unsigned threads, float angle_deg = BuildOptions().crease_angle_deg,
                              uint64_t memory_bytes = 0) const {
    BuildOptions options;
    options.input = folder_ / "part.ply";
    options.output = folder_ / ("part" + std::to_string(threads) + ".lode");
    options.threads = threads;
    options.memory_bytes = memory_bytes;
    options.triangles_per_node = 128;
    options.crease_angle_deg = angle_deg;
    build(options);
    return options.output;
  }

  test::WorkFolder folder_;
};

TEST_P(Creases, giveTheSameBytesForAnyNumberOfThreadsAndAnyMemory) {
  const std::string expected = readBytes(built(1));
  EXPECT_TRUE(readBytes(built(2)) == expected);
  EXPECT_TRUE(readBytes(built(8)) == expected);
  EXPECT_TRUE(readBytes(built(2, BuildOptions().crease_angle_deg, 1 << 16)) == expected) << "sorted on disk";
}

TEST_P(Creases, leaveEveryCutClosed) {
  const store::Reader reader(built(2));
  const store::NodeTree tree(reader.nodes());
  for (uint64_t seed = 0; seed < 50; ++seed) {
    store::OpenEdges open;
    open.add(store::assembleCut(reader, store::randomCut(tree, seed)));
    EXPECT_TRUE(open.edges().empty()) << "seed " << seed;
  }
}

struct SharedNormals {
  size_t corners = 0;     ///< corners of LODs at locked positions
  size_t on_creases = 0;  ///< corners at positions with several normals
  size_t strange = 0;     ///< corners with a normal that no leaf has there
};

/// I5: in all LODs, shared vertices have normals of the original surface.
SharedNormals sharedNormals(const store::Reader& reader) {
  std::map<uint64_t, std::set<uint16_t>> original;
  std::map<uint64_t, std::set<NodeKey>> leaves;
  for (const Node& node : reader.nodes()) {
    if (!node.isLeaf()) continue;
    const Mesh mesh = store::readLod(reader, node, 0);
    for (size_t i = 0; i < mesh.positions.size(); ++i) {
      original[mesh.positions[i].value].insert(mesh.vertex_attributes[i].normal);
      leaves[mesh.positions[i].value].insert(node.key);
    }
  }
  SharedNormals result;
  for (const Node& node : reader.nodes())
    for (uint32_t lod = 0; lod < node.lods.size(); ++lod) {
      const Mesh mesh = store::readLod(reader, node, lod);
      for (size_t i = 0; i < mesh.positions.size(); ++i) {
        const bool is_locked = std::ranges::any_of(leaves[mesh.positions[i].value], [&](NodeKey leaf) {
          return commonAncestor(leaf, node.key).depth() < node.key.depth();
        });
        if (!is_locked) continue;
        const std::set<uint16_t>& known = original[mesh.positions[i].value];
        ++result.corners;
        result.on_creases += known.size() > 1;
        result.strange += !known.contains(mesh.vertex_attributes[i].normal);
      }
    }
  return result;
}

TEST_P(Creases, haveTheSameNormalsOnBothSidesOfABorderInAllLods) {
  const SharedNormals found = sharedNormals(store::Reader(built(2)));
  EXPECT_EQ(found.strange, 0u);
  EXPECT_GT(found.on_creases, 100u);
}

TEST(ComputedNormals, equalTheOriginalsAtPositionsSharedByNodesInAllLods) {
  const test::WorkFolder folder;
  SampleOptions sample;
  sample.kind = "asteroid";
  sample.triangles = 20000;
  writeSample(sample, folder / "a.ply");
  BuildOptions options;
  options.input = folder / "a.ply";
  options.output = folder / "a.lode";
  options.triangles_per_node = 512;
  build(options);
  const SharedNormals found = sharedNormals(store::Reader(options.output));
  EXPECT_EQ(found.strange, 0u);
  EXPECT_GT(found.corners, 500u);
}

/// Returns the largest angle between a corner's normal and its triangle's, in degrees.
double worstAngle(const Mesh& mesh) {
  double least = 1;
  for (const glm::u32vec3& t : mesh.triangles) {
    const auto at = [&](int k) { return glm::dvec3(unpackPosition(mesh.positions[t[k]])); };
    const glm::dvec3 normal = glm::cross(at(1) - at(0), at(2) - at(0));
    if (glm::length(normal) == 0) continue;
    for (int k = 0; k < 3; ++k)
      least = std::min(least, glm::dot(glm::normalize(normal),
                                       glm::dvec3(decodeOctahedral(mesh.vertex_attributes[t[k]].normal))));
  }
  return glm::degrees(std::acos(std::clamp(least, -1.0, 1.0)));
}

TEST_P(Creases, staySharpFromTheOriginalToTheCoarsestCut) {
  const store::Reader sharp(built(2));
  const store::NodeTree tree(sharp.nodes());
  EXPECT_LT(worstAngle(store::assembleCut(sharp, store::leafCut(tree))), 5);
  const store::Cut coarsest = store::cutByTriangles(tree, 0);
  EXPECT_LT(worstAngle(store::assembleCut(sharp, coarsest)), 30) << coarsest.triangles << " triangles";
  const store::Reader smooth(built(1, 180));
  EXPECT_GT(worstAngle(store::assembleCut(smooth, store::leafCut(store::NodeTree(smooth.nodes())))), 40);
}

std::string nameOfPart(const testing::TestParamInfo<bool>& info) { return info.param ? "boredBox" : "cube"; }

INSTANTIATE_TEST_SUITE_P(Of, Creases, testing::Bool(), nameOfPart);

}  // namespace
}  // namespace lode::ingest
