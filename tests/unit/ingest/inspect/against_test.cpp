#include "server/ingest/inspect/against.h"

#include <functional>

#include <gtest/gtest.h>

#include "common/error.h"
#include "server/ingest/pipeline/build.h"
#include "server/sample/sample.h"
#include "server/store/reader.h"
#include "tests/support/work_folder.h"
#include "tests/unit/ingest/inspect/altered_store.h"
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

  void alter(const std::function<void(Node&)>& alter_node,
             const std::function<void(Mesh&)>& alter_leaf) const {
    alterStore(store_, altered_, alter_node, alter_leaf);
  }

  test::WorkFolder folder_;
  const std::filesystem::path input_ = folder_ / "a.ply", store_ = folder_ / "a.lode",
                              altered_ = folder_ / "b.lode";
};

TEST_F(Against, findsNoDifferenceInAFreshBuild) {
  const AgainstReport report = compare(store_);
  EXPECT_EQ(report.triangles, store::Reader(store_).summary().triangles);
  EXPECT_GT(report.lods, 10u);
  EXPECT_GE(report.least_ratio, 0.8);
  EXPECT_LT(report.median_ratio, 3);
}

TEST_F(Against, findsAFlippedTriangle) {
  bool is_done = false;
  alter({}, [&](Mesh& mesh) {
    if (!is_done) std::swap(mesh.triangles.back().x, mesh.triangles.back().y);
    is_done = true;
  });
  expectDifference("(I1)");
}

TEST_F(Against, findsADuplicateTriangleInPlaceOfAnother) {
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

TEST_F(Against, findsOneUnderstatedErrorForEverySeed) {
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

TEST(AgainstBadInput, agreesWithABuildOnSkippedBadValues) {
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
