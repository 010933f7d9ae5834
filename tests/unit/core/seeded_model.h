#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "client/core/lod/view_group.h"
#include "tests/unit/core/scripted_client.h"

namespace lode::core::fixture {

/// A model whose blobs the test delivers one by one.
class Seeded {
 protected:
  explicit Seeded(uint32_t seed, uint64_t memory_budget_bytes = 1ull << 40)
      : tree_({.seed = seed}), model_(summary(), memory_budget_bytes) {
    const BlobUse root_page{BlobKind::kRootPage, {kRootKey, 0}};
    model_.take(model_.summary().root_page, root_page, encodePage(tree_.rootPage()));
    deliver(*model_.firstRequest());
  }

  ModelSummary summary() const {
    ModelSummary summary;
    summary.lattice = SyntheticModel::lattice();
    summary.attributes = SyntheticModel::attributes();
    summary.box = tree_.nodes().at(kRootKey).box;
    summary.nodes = tree_.nodes().size();
    for (const auto& [key, node] : tree_.nodes())
      if (node.isLeaf()) summary.triangles += node.lods.front().triangles;
    return summary;
  }

  static ViewGroup seeing(const View& view, const RefineOptions& options = {}) {
    ViewGroup group(options);
    group.setView(view, 1);
    return group;
  }

  void deliver(const Request& request) {
    if (request.use.kind == BlobKind::kPage)
      return model_.take(request.blob, request.use, encodePage(tree_.pageBelow(request.use.mesh.node)));
    model_.take(request.blob, request.use, {});
    for (const DecodeJob& job : model_.takeDecodeJobs())
      model_.finishDecode({job.blob, job.use, tree_.mesh(job.use.mesh), nullptr, nullptr, ""});
  }

  /// Delivers the best requests of a view, up to a number, or until none is missing.
  void deliverBest(ViewGroup& group, int count) {
    for (; group.refine(model_), count > 0 && !group.requests().empty(); --count)
      deliver(group.requests().front());
  }

  static std::vector<std::pair<BlobUse, float>> orderOf(const ViewGroup& group) {
    std::vector<std::pair<BlobUse, float>> order;
    for (const Request& request : group.requests()) order.emplace_back(request.use, request.priority_px);
    return order;
  }

  const SyntheticModel tree_;
  Model model_;
};

}  // namespace lode::core::fixture
