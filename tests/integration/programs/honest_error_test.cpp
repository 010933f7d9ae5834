// I4: compares the stored error of each LOD with the deviation that dense sampling finds.

#include <algorithm>
#include <iostream>
#include <string>

#include <nlohmann/json.hpp>

#include "models.h"
#include "programs.h"
#include "server/store/export.h"
#include "server/store/reader.h"
#include "tests/support/surface_distance.h"
#include "tests/support/work_folder.h"

namespace lode::test {
namespace {

constexpr size_t kSamplesOfLod = 30000;
constexpr size_t kMaxLods = 200;  ///< largest number of LODs to check per model, evenly spread

/// Returns the original surface below a node.
TriangleSoup leavesBelow(const store::Reader& reader, NodeKey key) {
  TriangleSoup soup;
  for (const Node& node : reader.nodes()) {
    if (!node.isLeaf() || !key.contains(node.key)) continue;
    const TriangleSoup part = latticeSoup(store::readLod(reader, node, 0));
    soup.insert(soup.end(), part.begin(), part.end());
  }
  return soup;
}

struct LodError {
  std::string where;
  double stored_steps;
  SurfaceDistance sampled_steps;
};

std::vector<LodError> measureLods(const store::Reader& reader) {
  std::vector<std::pair<const Node*, uint32_t>> lods;
  for (const Node& node : reader.nodes()) {
    for (uint32_t r = 0; r < node.lods.size(); ++r) {
      if (!node.isLeaf() || r > 0) lods.emplace_back(&node, r);
    }
  }
  const size_t stride = std::max<size_t>(1, lods.size() / kMaxLods);
  std::vector<LodError> errors;
  NodeKey key{0};
  TriangleSoup original;
  for (size_t i = 0; i < lods.size(); i += stride) {
    const auto& [node, r] = lods[i];
    if (node->key != key) original = leavesBelow(reader, node->key);
    key = node->key;
    const TriangleSoup lod = latticeSoup(store::readLod(reader, *node, r));
    errors.push_back({std::to_string(node->key.value) + "/" + std::to_string(r),
                      node->lods[r].error_model / reader.summary().lattice.step,
                      surfaceDistance(original, lod, kSamplesOfLod)});
  }
  return errors;
}

class HonestError : public testing::TestWithParam<Model> {};

TEST_P(HonestError, isAtLeastWhatDenseSamplingFinds) {
  LODE_REQUIRE_MODEL(GetParam());
  const std::vector<LodError> errors = measureLods(store::Reader(GetParam().store()));
  ASSERT_FALSE(errors.empty());
  size_t below = 0;
  std::vector<double> ratios;
  for (const LodError& error : errors) {
    const double ratio = error.stored_steps / error.sampled_steps.both.max;
    below += ratio < 1;
    ratios.push_back(ratio);
    EXPECT_GE(ratio, 0.8) << error.where << ": stored " << error.stored_steps << " steps, original to LOD "
                          << error.sampled_steps.forward.max << ", back " << error.sampled_steps.backward.max;
  }
  EXPECT_LE(static_cast<double>(below), 0.01 * static_cast<double>(errors.size()))
      << below << " of " << errors.size() << " below";
  std::sort(ratios.begin(), ratios.end());
  std::cout << "stored error over sampled: least " << ratios.front() << ", median "
            << ratios[ratios.size() / 2] << ", largest " << ratios.back() << '\n';
}

INSTANTIATE_TEST_SUITE_P(Of, HonestError, testing::ValuesIn(models()), nameOf);

// In this sample, the LOD of 8,689 triangles and its source deviate most at the same point, inside a triangle
// of a leaf. Without a sample at this point, the stored error would be 0.91 times the true error.
TEST(HonestErrorOfSample, coversAWorstPlaceThatIsNoVertexOfCoarserLods) {
  const WorkFolder folder;
  const std::string model = folder / "a.ply", store = folder / "a.lode";
  ASSERT_EQ(
      lodestreamd({"sample", "asteroid", "--triangles", "300000", "--seed", "31337", "-o", model}).status, 0);
  ASSERT_EQ(lodestreamd({"build", model, "-o", store, "--triangles-per-node", "4096"}).status, 0);
  const Outcome verified =
      lodestreamd({"verify", store, "--against", model, "--lods", "all", "--cuts", "0", "--json"});
  EXPECT_GE(nlohmann::json::parse(verified.out)["against"]["least_ratio"], 1);
}

}  // namespace
}  // namespace lode::test
