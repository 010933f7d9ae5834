#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <vector>

#include <gtest/gtest.h>

#include "common/io/ply_writer.h"
#include "server/ingest/inspect/against.h"
#include "server/ingest/pipeline/build.h"
#include "server/sample/sample.h"
#include "server/store/export.h"
#include "server/store/reader.h"
#include "tests/support/loose_pieces.h"
#include "tests/support/surface_distance.h"
#include "tests/support/work_folder.h"

namespace lode::ingest {
namespace {

/// Builds a model and compares every LOD's stored error with points of all triangles below its node.
class HonestErrorOf {
 public:
  HonestErrorOf(const Mesh& model, uint32_t triangles_per_node) {
    writePly(folder_ / "a.ply", model, {});
    buildFrom(folder_ / "a.ply", triangles_per_node);
  }
  HonestErrorOf(const std::filesystem::path& model, uint32_t triangles_per_node) {
    buildFrom(model, triangles_per_node);
  }

  /// Smallest ratio of stored error to the largest distance of a point (corner or edge middle) from the LOD.
  double leastRatio() const {
    const store::Reader reader(folder_ / "a.lode");
    double least = INFINITY;
    for (const Node& node : reader.nodes())
      for (const double ratio : ratiosOf(reader, node)) least = std::min(least, ratio);
    return least;
  }

  /// Largest ratio in the root's LODs.
  double largestRatioOfRoot() const {
    const store::Reader reader(folder_ / "a.lode");
    return std::ranges::max(ratiosOf(reader, *reader.find(kRootKey)));
  }

 private:
  void buildFrom(const std::filesystem::path& model, uint32_t triangles_per_node) const {
    BuildOptions options;
    options.input = model;
    options.output = folder_ / "a.lode";
    options.triangles_per_node = triangles_per_node;
    build(options);
  }

  /// Ratios of LODs that differ from the leaves.
  static std::vector<double> ratiosOf(const store::Reader& reader, const Node& node) {
    std::vector<double> ratios;
    const test::TriangleSoup original = leavesBelow(reader, node.key);
    for (uint32_t r = node.isLeaf() ? 1 : 0; r < node.lods.size(); ++r) {
      if (node.lods[r].triangles == 0) continue;
      const test::DistanceField field(test::latticeSoup(store::readLod(reader, node, r)));
      double farthest = 0;
      for (const auto& [a, b, c] : original) {
        for (const glm::dvec3 point : {a, b, c, (a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0})
          farthest = std::max(farthest, field.distance(point));
      }
      if (farthest > 0) ratios.push_back(node.lods[r].error_model / reader.summary().lattice.step / farthest);
    }
    return ratios;
  }

  static test::TriangleSoup leavesBelow(const store::Reader& reader, NodeKey key) {
    test::TriangleSoup soup;
    for (const Node& node : reader.nodes()) {
      if (!node.isLeaf() || !key.contains(node.key)) continue;
      const test::TriangleSoup part = test::latticeSoup(store::readLod(reader, node, 0));
      soup.insert(soup.end(), part.begin(), part.end());
    }
    return soup;
  }

  test::WorkFolder folder_;
};

TEST(HonestError, countsPiecesThatVanishFarFromTheRest) {
  const HonestErrorOf scan(test::makeScanWithLoosePieces(160, 100, {.pieces = 60, .largest = 4}), 512);
  EXPECT_GE(scan.leastRatio(), 1);
}

TEST(HonestError, countsPiecesThatVanishInASoupOfThem) {
  Mesh soup;
  test::addLoosePieces(soup, {.pieces = 1500});
  EXPECT_GE(HonestErrorOf(soup, 512).leastRatio(), 1);
}

void writeTerrain(uint64_t seed, uint64_t triangles, const std::filesystem::path& file) {
  SampleOptions terrain;
  terrain.kind = "terrain";
  terrain.seed = seed;
  terrain.triangles = triangles;
  writeSample(terrain, file);
}

TEST(HonestError, doesNotAddUpBoundaryErrorsOverLevels) {
  const test::WorkFolder folder;
  writeTerrain(5, 30'000, folder / "terrain.ply");
  EXPECT_LE(HonestErrorOf(folder / "terrain.ply", 256).largestRatioOfRoot(), 2.5);
}

TEST(HonestError, coversClusteredTrianglesThatBridgeGaps) {
  const test::WorkFolder folder;
  writeTerrain(3, 40'000, folder / "terrain.ply");
  BuildOptions options;
  options.input = folder / "terrain.ply";
  options.output = folder / "terrain.lode";
  options.triangles_per_node = 2048;
  options.simplifier = Simplifier::kCluster;
  build(options);
  AgainstOptions against;
  against.input = options.input;
  against.store = options.output;
  EXPECT_GE(compareWithInput(against).least_ratio, 1);
}

TEST(HonestError, coversDetailBetweenTheVerticesOfAScan) {
  const char* const data = std::getenv("LODESTREAM_TEST_DATA");
  if (data == nullptr) GTEST_SKIP() << "set LODESTREAM_TEST_DATA to the folder with real scans";
  const std::filesystem::path bunny = std::filesystem::path(data) / "a_bunny_zipper_ascii.ply";
  EXPECT_GE(HonestErrorOf(bunny, 1024).leastRatio(), 1);
}

}  // namespace
}  // namespace lode::ingest
