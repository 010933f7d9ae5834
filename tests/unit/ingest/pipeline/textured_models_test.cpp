// Textured models of the test data, from PLY to store and back.

#include <array>
#include <cstdlib>
#include <map>
#include <string>

#include <gtest/gtest.h>

#include "server/ingest/inspect/against.h"
#include "server/ingest/inspect/doctor.h"
#include "server/ingest/pipeline/build.h"
#include "server/store/cut.h"
#include "server/store/export.h"
#include "server/store/reader.h"
#include "server/store/verify.h"
#include "tests/support/work_folder.h"

namespace lode::ingest {
namespace {

constexpr uint32_t kMostRootTriangles = 700;
constexpr double kMostNewSeams = 0.005;  ///< share of a cut's edges between nodes

struct TexturedFile {
  const char* name;
  size_t textures;
};

class TexturedModels : public testing::TestWithParam<TexturedFile> {
 protected:
  void SetUp() override {
    const char* const data = std::getenv("LODESTREAM_TEST_DATA");
    if (data == nullptr) GTEST_SKIP() << "set LODESTREAM_TEST_DATA to the folder with MANIFEST.tsv";
    input_ = std::filesystem::path(data) / (std::string(GetParam().name) + ".ply");
    BuildOptions options;
    options.input = input_;
    options.output = store_;
    options.triangles_per_node = 2048;  // small, so that even small models have several nodes
    const BuildReport report = build(options);
    // Allow warnings about faces, about properties and that there is no image, but none about an image.
    for (const std::string& warning : report.warnings)
      EXPECT_TRUE(warning.find("a build drops") != std::string::npos ||
                  warning.find("ignored properties") != std::string::npos ||
                  warning.find("its header names no image") != std::string::npos)
          << warning;
  }

  test::WorkFolder folder_;
  std::filesystem::path input_, store_ = folder_ / "a.lode";
};

TEST_P(TexturedModels, areBuiltWithAllTheirImages) {
  const store::Reader reader(store_);
  EXPECT_TRUE(reader.summary().attributes.has(AttributeSet::kTexture));
  EXPECT_EQ(reader.textures().textures.size(), GetParam().textures);
  for (const Texture& texture : reader.textures().textures) EXPECT_GT(texture.tiles.size(), 0u);
}

TEST_P(TexturedModels, areSoundAndHoldEveryTriangleWithItsAttributes) {
  const store::VerifyReport report = store::verifyStore(store_, {.random_cuts = 10});
  EXPECT_GT(report.tiles + 1, GetParam().textures);
  AgainstOptions against;
  against.store = store_;
  against.input = input_;
  against.lods = 20;
  EXPECT_GT(compareWithInput(against).triangles, 0u);
}

TEST_P(TexturedModels, haveASmallRoot) {
  EXPECT_LE(store::Reader(store_).nodes()[0].lods.back().triangles, kMostRootTriangles);
}

TEST_P(TexturedModels, haveOneMaterialPerTriangleInEveryLod) {
  const store::Reader reader(store_);
  for (const Node& node : reader.nodes())
    for (uint32_t r = 0; r < node.lods.size(); ++r) {
      const Mesh mesh = store::readLod(reader, node, r);
      for (const glm::u32vec3& t : mesh.triangles) {
        const uint16_t material = mesh.vertex_attributes[t.x].material;
        ASSERT_EQ(mesh.vertex_attributes[t.y].material, material) << node.key.value << " lod " << r;
        ASSERT_EQ(mesh.vertex_attributes[t.z].material, material) << node.key.value << " lod " << r;
      }
    }
}

/// Counts new seams of a cut: edges between two nodes where the texture jumps although it does not in the
/// leaves. Coarse LODs have a few.
TEST_P(TexturedModels, showHardlyAnyNewSeamsBetweenTheNodesOfRandomCuts) {
  const store::Reader reader(store_);
  const store::NodeTree tree(reader.nodes());
  // Data of a directed edge: the node, and the texture coordinates and materials at both ends.
  using Wedges = std::array<uint64_t, 2>;
  struct Use {
    uint32_t node;
    Wedges wedges;
  };
  using Edges = std::multimap<std::array<uint64_t, 2>, Use>;
  const auto wedgeOf = [](const VertexAttributes& attributes) {
    return uint64_t{attributes.texture.x} << 32 | uint64_t{attributes.texture.y} << 16 | attributes.material;
  };
  const auto edgesOf = [&](const store::Cut& cut) {
    Edges edges;
    for (const store::CutItem item : cut.items) {
      const Mesh mesh = store::readLod(reader, tree.node(item.node), item.lod);
      for (const glm::u32vec3& t : mesh.triangles)
        for (int k = 0; k < 3; ++k) {
          const uint32_t a = t[k], b = t[(k + 1) % 3];
          edges.insert(
              {{mesh.positions[a].value, mesh.positions[b].value},
               {item.node, {wedgeOf(mesh.vertex_attributes[a]), wedgeOf(mesh.vertex_attributes[b])}}});
        }
    }
    return edges;
  };
  // Returns true if a pair of triangles meets at the edge without a jump.
  const auto isSmooth = [](const Edges& edges, const std::array<uint64_t, 2>& edge, bool across_nodes) {
    const auto [begin, end] = edges.equal_range(edge);
    const auto [back_begin, back_end] = edges.equal_range({edge[1], edge[0]});
    bool met = false;
    for (auto here = begin; here != end; ++here)
      for (auto there = back_begin; there != back_end; ++there) {
        if (across_nodes && here->second.node == there->second.node) continue;
        met = true;
        if (here->second.wedges == Wedges{there->second.wedges[1], there->second.wedges[0]}) return true;
      }
    return !met;
  };
  const Edges leaves = edgesOf(store::leafCut(tree));
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    const Edges edges = edgesOf(store::randomCut(tree, seed));
    size_t seams = 0, shared = 0;
    for (auto edge = edges.begin(); edge != edges.end(); edge = edges.upper_bound(edge->first)) {
      if (!leaves.contains(edge->first) || !isSmooth(leaves, edge->first, false)) continue;
      ++shared;
      seams += !isSmooth(edges, edge->first, true);
    }
    EXPECT_LE(seams, kMostNewSeams * static_cast<double>(shared)) << "of " << shared << ", seed " << seed;
  }
}

/// Models whose images are most of the store.
class ModelsWithImages : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    const char* const data = std::getenv("LODESTREAM_TEST_DATA");
    if (data == nullptr) GTEST_SKIP() << "set LODESTREAM_TEST_DATA to the folder with MANIFEST.tsv";
    options_.input = std::filesystem::path(data) / (std::string(GetParam()) + ".ply");
    options_.output = folder_ / "a.lode";
  }

  test::WorkFolder folder_;
  BuildOptions options_;
};

TEST_P(ModelsWithImages, areForecastInSizeWithinHalf) {
  const DoctorReport report =
      examine({.input = options_.input, .memory_bytes = 0, .threads = 1, .temporary_folder = folder_.path()});
  ASSERT_TRUE(report.forecast);
  const auto forecast = static_cast<double>(report.forecast->store_bytes);
  const BuildReport built = build(options_);
  EXPECT_LE(forecast, 1.5 * static_cast<double>(built.summary.bytes));
  EXPECT_GE(forecast, static_cast<double>(built.summary.bytes) / 1.5);
}

INSTANTIATE_TEST_SUITE_P(
    TestData, TexturedModels,
    testing::Values(TexturedFile{"c_box_st_ascii", 0}, TexturedFile{"c_cube_texture_uv_le", 0},
                    TexturedFile{"c_cube_uv_st_quads_ascii", 0}, TexturedFile{"c_fuze_spaces_le", 1},
                    TexturedFile{"c_jungle_multitex_le", 16}, TexturedFile{"c_sofa_texcoord_notexfile_le", 0},
                    TexturedFile{"c_spot_wedge_texcoord_le", 1}, TexturedFile{"c_steampunk_3tex_le", 3},
                    TexturedFile{"c_suzanne_st_mixed_ascii", 0}),
    [](const auto& test) { return std::string(test.param.name); });

INSTANTIATE_TEST_SUITE_P(TestData, ModelsWithImages,
                         testing::Values("c_fuze_spaces_le", "c_jungle_multitex_le",
                                         "c_spot_wedge_texcoord_le", "c_steampunk_3tex_le"),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
}  // namespace lode::ingest
