// Parts estimated as hidden arrive last, and never change the converged cut, even if the estimate is wrong.

#include "tests/support/seeds.h"
#include "tests/unit/core/scripted_client.h"

namespace lode::core {
namespace {

using namespace fixture;

/// Returns what closeView() sees behind a near wall that hides its left side or everything.
SeenPlaces seenPastAWall(const SyntheticModel& model, bool all) {
  const View view = closeView();
  Cut cut;
  for (const auto& [key, node] : model.nodes())
    if (!all && node.isLeaf()) cut.parts.push_back({key, 0, true, 0, model.mesh({key, 0})});
  const glm::dvec3 right = glm::cross(view.forward, view.up);
  const glm::dvec3 middle = view.eye_model + view.forward * 100.0;
  Mesh wall;
  for (const auto& [x, y] : {std::pair{-300., -300.}, {0., -300.}, {0., 300.}, {-300., 300.}}) {
    const glm::dvec3 corner = middle + right * x + view.up * y;
    wall.positions.push_back(packPosition(glm::uvec3(corner / SyntheticModel::lattice().step)));
  }
  wall.triangles = {{0, 1, 2}, {0, 2, 3}};
  if (!all) cut.parts.push_back({kRootKey, 0, true, 0, std::make_shared<const Mesh>(std::move(wall))});
  ModelSummary summary;
  summary.lattice = SyntheticModel::lattice();
  summary.box = model.nodes().at(kRootKey).box;
  cut.view = view;
  return SeenPlaces::of(cut, summary).value();
}

class HiddenParts : public testing::TestWithParam<uint32_t> {
 protected:
  SyntheticModel model_{{.seed = GetParam(), .empty_chance = GetParam() % 2 ? 0.1 : 0.0}};
  std::mt19937 random_{GetParam() * 7919};
};

INSTANTIATE_TEST_SUITE_P(Seeds, HiddenParts, testing::Range(1u, 1 + lode::test::kSeeds));

TEST_P(HiddenParts, keepTheConvergedCutAndLeaveNoHoles) {
  for (const bool all : {false, true}) {
    Scripted client(model_);
    client.seeOnly(seenPastAWall(model_, all));
    const auto check = [&](const Refinement& now) {
      if (now.cut) expectComplete(model_, *now.cut, now.settled);
    };
    client.converge(closeView(), {.threshold_px = 2}, random_, check);
    EXPECT_TRUE(client.last().cut->converged);
    EXPECT_TRUE(client.last().settled);
    EXPECT_EQ(partsOf(*client.last().cut), BruteForce(model_, closeView(), 2).parts());
  }
}

TEST_P(HiddenParts, areRequestedAfterAllVisibleParts) {
  constexpr RefineOptions kOptions{.threshold_px = 1};
  const SeenPlaces seen = seenPastAWall(model_, false);
  Scripted client(model_);
  client.seeOnly(seen);
  const auto isForWhatIsSeen = [](const Request& request) {
    return request.priority_px > kOptions.threshold_px;
  };
  const auto next = [&]() -> const std::vector<Request>& {
    return client.refineFor(closeView(), kOptions).wanted;
  };
  while (!next().empty() && isForWhatIsSeen(client.last().wanted.front()))
    client.deliver(client.last().wanted.front());
  const uint64_t until_seen_bytes = client.deliveredPayloadBytes();
  const Parts shown = partsOf(*client.last().cut);
  const Parts wanted = BruteForce(model_, closeView(), kOptions.threshold_px).parts();
  for (const auto& [key, lod] : wanted) {
    const ModelBox box = toModelBox(model_.nodes().at(key).box, SyntheticModel::lattice().step);
    if (!boxMayBeVisible(box, closeView(), kMarginWidening) || !seen.in(key)) continue;
    ASSERT_TRUE(shown.contains(key)) << key.value;
    EXPECT_EQ(shown.at(key), lod) << key.value;
  }
  while (!next().empty()) client.deliver(client.last().wanted.front());
  EXPECT_LT(until_seen_bytes * 20, client.deliveredPayloadBytes() * 19);
}

}  // namespace
}  // namespace lode::core
