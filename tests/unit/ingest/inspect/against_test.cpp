#include "server/ingest/inspect/against.h"

#include <functional>

#include <gtest/gtest.h>

#include "common/codec/draco_codec.h"
#include "common/error.h"
#include "server/ingest/pipeline/build.h"
#include "server/sample/sample.h"
#include "server/store/export.h"
#include "server/store/reader.h"
#include "server/store/writer.h"
#include "tests/support/work_folder.h"
#include "tests/unit/ingest/ply/ply_fixture.h"

namespace lode::ingest {
namespace {

/// A sample, its store, and altered copies of the store.
class Against : public testing::Test {
 protected:
  void SetUp() override {
    SampleOptions sample;
    sample.kind = "asteroid";
    sample.triangles = 12000;
    sample.attributes.bits = AttributeSet::kColour | AttributeSet::kTexture;
    writeSample(sample, input_);
    BuildOptions options;
    options.input = input_;
    options.output = store_;
    options.triangles_per_node = 1024;
    build(options);
  }

  AgainstReport compare(const std::filesystem::path& store, uint64_t seed = 1) const {
    AgainstOptions options;
    options.seed = seed;
    options.store = store;
    options.input = input_;
    options.memory_bytes = 1 << 20;
    return compareWithInput(options);
  }

  void expectDifference(const std::string& words, uint64_t seed = 1) const {
    try {
      compare(altered_, seed);
      ADD_FAILURE() << "no difference found";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kFormat);
      EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
    }
  }

  /// Writes a valid store after applying the functions to its nodes and leaf meshes.
  void alter(const std::function<void(Node&)>& alter_node,
             const std::function<void(Mesh&)>& alter_leaf) const {
    const store::Reader reader(store_);
    const double step = reader.summary().lattice.step;
    std::vector<Node> nodes(reader.nodes().begin(), reader.nodes().end());
    store::Writer writer(altered_);
    for (Node& node : nodes) {
      node.child_page = {};
      for (uint32_t r = 0; r < node.lods.size(); ++r) {
        if (!node.lods[r].payload) continue;
        std::vector<std::byte> bytes = reader.readBlob(node.lods[r].payload.number);
        if (node.isLeaf() && alter_leaf) {
          Mesh mesh = store::readLod(reader, node, r);
          alter_leaf(mesh);
          const EncodedPayload payload = encodePayload(mesh, step);
          node.lods[r].vertices = payload.vertices;
          bytes = payload.bytes;
        }
        node.lods[r].payload = writer.addBlob(bytes);
      }
      if (alter_node) alter_node(node);
    }
    writer.addTextures(reader.textures());
    writer.finish(reader.summary(), std::move(nodes));
  }

  test::WorkFolder folder_;
  const std::filesystem::path input_ = folder_ / "a.ply", store_ = folder_ / "a.lode",
                              altered_ = folder_ / "b.lode";
};

TEST_F(Against, findsNoDifferenceInWhatWasBuilt) {
  const AgainstReport report = compare(store_);
  EXPECT_EQ(report.triangles, store::Reader(store_).summary().triangles);
  EXPECT_GT(report.lods, 10u);
  EXPECT_GE(report.least_ratio, 0.8);
  EXPECT_LT(report.median_ratio, 3);
}

TEST_F(Against, findsATriangleThatIsTurnedRound) {
  bool is_done = false;
  alter({}, [&](Mesh& mesh) {
    if (!is_done) std::swap(mesh.triangles.back().x, mesh.triangles.back().y);
    is_done = true;
  });
  expectDifference("(I1)");
}

TEST_F(Against, findsATriangleThatIsThereTwiceInPlaceOfAnother) {
  bool is_done = false;
  alter({}, [&](Mesh& mesh) {
    if (is_done || mesh.triangles.size() < 2) return;
    mesh.triangles.back() = mesh.triangles.front();
    is_done = true;
  });
  expectDifference("(I1)");
}

TEST_F(Against, findsACornerWithOtherTextureCoordinates) {
  bool is_done = false;
  alter({}, [&](Mesh& mesh) {
    if (!is_done) mesh.vertex_attributes[mesh.triangles.back().x].texture.y ^= 1;
    is_done = true;
  });
  expectDifference("(I1)");
}

TEST_F(Against, findsErrorsThatAreGivenTooSmall) {
  alter(
      [](Node& node) {
        for (Lod& lod : node.lods) lod.error_model *= 0.4f;
      },
      {});
  expectDifference("(I4)");
}

TEST_F(Against, findsOneErrorThatIsGivenTooSmallWhateverTheSeed) {
  bool is_done = false;
  alter(
      [&](Node& node) {
        if (node.isLeaf() || node.key == kRootKey || is_done) return;
        node.lods[0].error_model *= 0.4f;
        is_done = true;
      },
      {});
  for (uint64_t seed = 1; seed <= 3; ++seed) expectDifference("LOD 0: its stored error is ", seed);
}

TEST(AgainstBadInput, agreesWithABuildThatSkipsBadValuesOnWhatWasDropped) {
  const PlyFolder folder;
  BuildOptions options;
  options.input = folder.write(
      "ply\nformat ascii 1.0\nelement vertex 7\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 5\nproperty list uchar int vertex_indices\nend_header\n"
      "0 0 0\n1 0 0\n1 1 0\n0 1 0\nnan 0 0\ninf 0 0\n0 0 0\n"
      "4 0 1 2 3\n4 0 1 2 9\n3 0 1 4\n3 0 1 0\n3 0 6 1\n");
  options.output = folder / "a.lode";
  options.skip_bad = true;
  const BuildReport built = build(options);
  EXPECT_EQ(built.summary.triangles, 2u);
  EXPECT_EQ(built.summary.dropped, 5u) << "of the 7 of the input; two bad vertices are none";
  AgainstOptions against;
  against.store = options.output;
  against.input = options.input;
  EXPECT_EQ(compareWithInput(against).dropped, 5u);
}

}  // namespace
}  // namespace lode::ingest
