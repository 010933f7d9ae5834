#pragma once

#include <map>
#include <optional>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "client/core/lod/refiner.h"
#include "tests/unit/core/synthetic_model.h"

namespace lode::core::fixture {

using Parts = std::map<NodeKey, uint32_t>;

inline View lookingAt(glm::dvec3 eye, glm::dvec3 target, uint32_t height_px = 720) {
  View view;
  view.eye_model = eye;
  view.forward = glm::normalize(target - eye);
  view.up = glm::normalize(glm::cross(glm::cross(view.forward, glm::dvec3(0.1, 1, 0.2)), view.forward));
  view.width_px = height_px * 16 / 9;
  view.height_px = height_px;
  return view;
}

inline View closeView() { return lookingAt({512, 512, 1400}, {200, 300, 0}); }
inline View farView() { return lookingAt({4000, 9000, 30000}, {512, 512, 512}); }
inline View insideView() { return lookingAt({500, 510, 520}, {0, 0, 400}); }

/// Reference implementation of the converged cut, as simple as possible.
class BruteForce {
 public:
  /// @param lost  blobs that cannot be loaded.
  BruteForce(const SyntheticModel& model, const View& view, float threshold_px,
             const std::set<uint32_t>& lost = {})
      : model_(model), view_(view), threshold_px_(threshold_px), lost_(lost) {
    visit(kRootKey);
  }
  const Parts& parts() const { return parts_; }
  uint64_t triangles() const {
    uint64_t triangles = 0;
    for (const auto& [key, lod] : parts_) triangles += model_.nodes().at(key).lods[lod].triangles;
    return triangles;
  }
  float errorPx(NodeKey key, uint32_t lod) const {
    const Node& node = model_.nodes().at(key);
    const ModelBox box = toModelBox(node.box, SyntheticModel::lattice().step);
    return screenErrorPx(std::max(node.lods[lod].error_model, node.lods[lod].appearance_error_model),
                         distanceToBox(view_.eye_model, box), view_);
  }

 private:
  void visit(NodeKey key) {
    const Node& node = model_.nodes().at(key);
    const std::vector<uint32_t> lods = lodsOf(node);
    if (!lods.empty() && !boxMayBeVisible(toModelBox(node.box, SyntheticModel::lattice().step), view_))
      return add(node, lods.back());
    for (size_t i = lods.size(); i-- > 0;)
      if (errorPx(key, lods[i]) <= threshold_px_) return add(node, lods[i]);
    if (!isReplaceable(node)) return add(node, lods.front());
    for (unsigned octant = 0; octant < 8; ++octant)
      if ((node.child_mask >> octant & 1) != 0) visit(key.child(octant));
  }
  /// Returns the loadable LODs, finest first.
  std::vector<uint32_t> lodsOf(const Node& node) const {
    std::vector<uint32_t> lods;
    for (uint32_t lod = 0; lod < node.lods.size(); ++lod)
      if (node.lods[lod].triangles == 0 || !lost_.contains(node.lods[lod].payload.number))
        lods.push_back(lod);
    return lods;
  }
  bool isReplaceable(const Node& node) const {
    if (node.isLeaf() || (node.child_page && lost_.contains(node.child_page.number))) return false;
    for (unsigned octant = 0; octant < 8; ++octant)
      if ((node.child_mask >> octant & 1) != 0 && !mayBeShown(model_.nodes().at(node.key.child(octant))))
        return false;
    return true;
  }
  bool mayBeShown(const Node& node) const { return !lodsOf(node).empty() || isReplaceable(node); }
  void add(const Node& node, uint32_t lod) {
    if (node.lods[lod].triangles != 0) parts_[node.key] = lod;
  }

  const SyntheticModel& model_;
  const View view_;
  const float threshold_px_;
  const std::set<uint32_t> lost_;
  Parts parts_;
};

inline Parts partsOf(const Cut& cut) {
  Parts parts;
  for (const CutPart& part : cut.parts) parts[part.node] = part.lod;
  EXPECT_EQ(parts.size(), cut.parts.size());
  return parts;
}

/// A client whose requests the test answers in any order.
class Scripted {
 public:
  explicit Scripted(const SyntheticModel& model, uint64_t budget_bytes = 1ull << 40)
      : model_(model), hierarchy_(model.nodes().size()), cache_(budget_bytes) {
    hierarchy_.addRootPage(model.rootPage());
  }

  const Refinement& refineFor(const View& view, const RefineOptions& options) {
    const std::vector<HeldNode> held = std::move(last_.held);
    last_ = refine({hierarchy_, cache_, SyntheticModel::lattice().step, SyntheticModel::attributes()}, view,
                   options, held, seen_ ? &*seen_ : nullptr);
    cache_.use(last_.in_use, last_.ancestors);
    cache_.trim();
    hierarchy_.use(last_.pages, options.hierarchy_budget_bytes);
    return last_;
  }

  /// Makes a blob unavailable.
  void lose(uint32_t blob) { lost_.insert(blob); }

  void deliver(const Request& wanted) {
    if (lost_.contains(wanted.blob.number)) return hierarchy_.lose(wanted.blob.number);
    const MeshKey& mesh = wanted.use.mesh;
    if (wanted.use.kind == BlobKind::kPage) {
      hierarchy_.addPage(mesh.node, model_.pageBelow(mesh.node));
    } else {
      delivered_payload_bytes_ += wanted.blob.bytes;
      cache_.insert(mesh, model_.mesh(mesh));
    }
  }

  /// Delivers random requests until none is left. @param check  called on every cut.
  template <typename Check>
  void converge(const View& view, const RefineOptions& options, std::mt19937& random, Check check) {
    for (size_t round = 0; round < 20000; ++round) {
      refineFor(view, options);
      check(last_);
      if (last_.wanted.empty()) return;
      deliver(last_.wanted[random() % last_.wanted.size()]);
    }
    FAIL() << "requests without end";
  }

  /// Sets the occlusion estimate for the following refinements.
  void seeOnly(const SeenPlaces& seen) { seen_ = seen; }

  const Refinement& last() const { return last_; }
  const Hierarchy& hierarchy() const { return hierarchy_; }
  MeshCache& cache() { return cache_; }
  uint64_t deliveredPayloadBytes() const { return delivered_payload_bytes_; }

 private:
  const SyntheticModel& model_;
  Hierarchy hierarchy_;
  MeshCache cache_;
  std::optional<SeenPlaces> seen_;
  std::set<uint32_t> lost_;
  Refinement last_;
  uint64_t delivered_payload_bytes_ = 0;
};

inline const auto kNoCheck = [](const Refinement&) {};

inline bool isNear(const SyntheticModel& model, NodeKey node, const View& view) {
  return boxMayBeVisible(toModelBox(model.nodes().at(node).box, SyntheticModel::lattice().step), view,
                         kMarginWidening);
}

/// Expects exactly one part per leaf, or none where an LOD on its path is empty, or where the leaf is outside
/// the margin of a cut that has not settled.
inline void expectComplete(const SyntheticModel& model, const Cut& cut, bool settled) {
  const Parts parts = partsOf(cut);
  for (const NodeKey leaf : model.leaves()) {
    int covering = 0;
    bool may_be_empty = !settled && !isNear(model, leaf, cut.view);
    for (int depth = 0; depth <= leaf.depth(); ++depth) {
      const NodeKey key = leaf.ancestorAt(depth);
      covering += static_cast<int>(parts.count(key));
      for (const Lod& lod : model.nodes().at(key).lods) may_be_empty |= lod.triangles == 0;
    }
    if (may_be_empty) {
      ASSERT_LE(covering, 1) << leaf.value;
    } else {
      ASSERT_EQ(covering, 1) << leaf.value;
    }
  }
}

}  // namespace lode::core::fixture
