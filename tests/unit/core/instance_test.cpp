#include "client/core/instance.h"

#include <algorithm>
#include <limits>

#include "tests/unit/core/scripted_client.h"

namespace lode::core {
namespace {

using namespace test;

class InstanceOnSeeds : public testing::TestWithParam<uint32_t> {
 protected:
  InstanceOnSeeds() : model_(summary(), 1ull << 40) {
    const BlobUse root_page{BlobKind::kRootPage, {kRootKey, 0}};
    model_.take(model_.summary().root_page, root_page, encodePage(tree_.rootPage()));
    deliver(*model_.firstWish());
  }

  ModelSummary summary() const {
    ModelSummary summary;
    summary.lattice = SyntheticModel::lattice();
    summary.attributes = SyntheticModel::attributes();
    summary.box = tree_.nodes().at(kRootKey).box;
    summary.nodes = tree_.nodes().size();
    return summary;
  }

  static Instance seeing(const View& view) {
    Instance instance(std::numeric_limits<uint64_t>::max());
    instance.setView(view, 1);
    return instance;
  }

  void deliver(const Wish& wish) {
    if (wish.use.kind == BlobKind::kPage)
      return model_.take(wish.blob, wish.use, encodePage(tree_.pageBelow(wish.use.mesh.node)));
    model_.take(wish.blob, wish.use, {});
    for (const DecodeJob& job : model_.takeDecodeJobs())
      model_.finishDecode({job.blob, job.use, tree_.mesh(job.use.mesh), nullptr, nullptr, ""});
  }

  /// The best wishes of a view come, so many, or until no more is missing.
  void deliverBest(Instance& instance, int count) {
    for (; instance.refine(model_), count > 0 && !instance.wishes().empty(); --count)
      deliver(instance.wishes().front());
  }

  static std::vector<std::pair<BlobUse, float>> orderOf(const Instance& instance) {
    std::vector<std::pair<BlobUse, float>> order;
    for (const Wish& wish : instance.wishes()) order.emplace_back(wish.use, wish.priority_px);
    return order;
  }

  const SyntheticModel tree_{{.seed = GetParam()}};
  Model model_;
};

INSTANTIATE_TEST_SUITE_P(Seeds, InstanceOnSeeds, testing::Range(1u, 7u));

const View kFront = lookingAt({512, 512, 2500}, {512, 512, 512}),
           kBack = lookingAt({512, 512, -1500}, {512, 512, 512});

TEST_P(InstanceOnSeeds, asksForWhatIsSeenByTheViewAtHandWhateverWasSeenBefore) {
  Instance turned = seeing(kFront);
  deliverBest(turned, 10);
  turned.setView(kBack, 1);
  turned.refine(model_);
  Instance fresh = seeing(kBack);
  fresh.refine(model_);
  EXPECT_EQ(orderOf(turned), orderOf(fresh));
}

TEST_P(InstanceOnSeeds, looksAnewAtWhatIsSeenAsTheCutBecomesFiner) {
  Instance early = seeing(kFront);
  early.refine(model_);
  const uint64_t first_triangles = early.cut()->triangles;
  while (early.cut()->triangles < 2 * first_triangles && !early.wishes().empty()) deliverBest(early, 1);
  Instance late = seeing(kFront);
  late.refine(model_);
  EXPECT_EQ(orderOf(early), orderOf(late));
}

}  // namespace
}  // namespace lode::core
