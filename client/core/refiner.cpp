#include "client/core/refiner.h"

#include <algorithm>
#include <queue>
#include <tuple>
#include <unordered_map>

namespace lode::core {
namespace {

// Pages are small, and nothing below them can be asked for without them.
constexpr float kPagePriorityFactor = 16;

constexpr uint64_t kCoverBytesRatio = 20;  // a covering step costs at most a twentieth of what it bridges

/// What the wanted cut makes of a node.
enum class Role : uint8_t {
  kPart,      // it is in the cut
  kExpanded,  // its children are
  kBlocked,   // its children should be, but are not known yet
};

struct Planned {
  const Node* node = nullptr;
  bool visible = true;
  bool near = true;  // visible, or would be if the camera turned a little
  double distance_model = 0;
  Role role = Role::kPart;
  uint32_t rung = 0;
  std::optional<uint32_t> cover_rung;  // the node is in the covering step at this rung
};

/// A part that may have to give way. Largest error first, ties by key.
struct Candidate {
  float error_px = 0;
  NodeKey node;
  friend bool operator<(const Candidate& a, const Candidate& b) noexcept {
    return a.error_px != b.error_px ? a.error_px < b.error_px : b.node < a.node;
  }
};

class Run {
 public:
  Run(const Hierarchy& hierarchy, const MeshCache& cache, const Lattice& lattice, AttributeSet attributes,
      const View& view, const RefineOptions& options)
      : hierarchy_(hierarchy),
        cache_(cache),
        step_(lattice.step),
        attributes_(attributes),
        view_(view),
        options_(options) {}

  Refinement refine() {
    const Node* root = hierarchy_.root();
    if (!root) return {};
    plan(*root);
    chooseCovers(plan_.at(kRootKey.value));
    cut_ = std::make_shared<Cut>();
    cut_->view = view_;
    const bool has_cut = near(*root) ? covered(*root) : anyReady(*root);
    if (has_cut) {
      show(*root);
    } else {
      wish({kRootKey, lastRung(*root)}, std::numeric_limits<float>::max(), true);
      exact_ = false;
    }
    return finish(has_cut);
  }

 private:
  // ---- the wanted cut

  static uint32_t lastRung(const Node& node) { return static_cast<uint32_t>(node.rungs.size()) - 1; }

  Planned place(const Node& node) const {
    if (node.box.empty()) return {&node, false, false, 0, Role::kPart, lastRung(node), {}};
    const ModelBox box = toModelBox(node.box, step_);
    const bool near = boxMayBeVisible(box, view_, kMarginWidening);
    return {&node,       near && boxMayBeVisible(box, view_),
            near,        distanceToBox(view_.eye_model, box),
            Role::kPart, lastRung(node),
            {}};
  }

  float errorPx(const Planned& planned, uint32_t rung) const {
    const Rung& of = planned.node->rungs[rung];
    return screenErrorPx(std::max(of.error_model, of.appearance_error_model), planned.distance_model, view_);
  }

  uint64_t partBytes(const Rung& rung) const {
    const uint64_t mesh_bytes = meshBytes(rung.vertices, rung.triangles, attributes_);
    return kPartBytes + (rung.triangles == 0 ? 0 : mesh_bytes);
  }

  void add(const Node& node) {
    const Planned& planned = plan_[node.key.value] = place(node);
    triangles_ += node.rungs.back().triangles;
    cut_bytes_ += partBytes(node.rungs.back());
    enqueue(planned);
  }

  void enqueue(const Planned& planned) {
    if (planned.visible) queue_.push({errorPx(planned, planned.rung), planned.node->key});
  }

  void plan(const Node& root) {
    add(root);
    while (!queue_.empty()) {
      const Candidate worst = queue_.top();
      if (worst.error_px <= options_.threshold_px) return;
      queue_.pop();
      if (!giveWay(plan_.at(worst.node.value))) return;
    }
  }

  /// @return false if a budget forbids it.
  bool giveWay(Planned& planned) {
    const Node& node = *planned.node;
    if (planned.rung == 0 && node.isLeaf()) return true;
    if (planned.rung == 0 && !hierarchy_.childrenKnown(node)) {
      if (hierarchy_.bytes() >= options_.hierarchy_budget_bytes) {
        limited_ = true;
        return true;
      }
      planned.role = Role::kBlocked;
      blocked_ = true;
      return true;
    }
    const Rung& from = node.rungs[planned.rung];
    uint64_t triangles = triangles_ - from.triangles;
    uint64_t bytes = cut_bytes_ - partBytes(from);
    const auto admit = [&](const Rung& rung) {
      triangles += rung.triangles;
      bytes += partBytes(rung);
    };
    if (planned.rung > 0) {
      admit(node.rungs[planned.rung - 1]);
    } else {
      forEachChild(node, [&](const Node& child) { admit(child.rungs.back()); });
    }
    if (triangles > options_.triangle_budget || bytes > options_.cut_budget_bytes) {
      limited_ = true;
      return false;
    }
    triangles_ -= from.triangles;
    cut_bytes_ -= partBytes(from);
    if (planned.rung > 0) {
      --planned.rung;
      triangles_ = triangles;
      cut_bytes_ = bytes;
      enqueue(planned);
    } else {
      planned.role = Role::kExpanded;
      forEachChild(node, [&](const Node& child) { add(child); });
    }
    return true;
  }

  struct Below {
    uint64_t bytes = 0;    // of the wanted cut's payloads near the view
    bool settled = false;  // a covering step was chosen, or not all of it is known yet
  };

  /// Chooses the covering step: on each way down the deepest expanded node, at its finest rung, that costs
  /// little against what is wanted below it. It does not depend on what is resident, so that wishes do not
  /// waver.
  Below chooseCovers(Planned& planned) {
    const Node& node = *planned.node;
    if (planned.role == Role::kPart)
      return {planned.near ? node.rungs[planned.rung].payload.bytes : 0, false};
    if (planned.role == Role::kBlocked) return {0, true};
    Below below;
    forEachChild(node, [&](const Node& child) {
      const Below more = chooseCovers(plan_.at(child.key.value));
      below.bytes += more.bytes;
      below.settled |= more.settled;
    });
    if (below.settled) return below;
    const auto cheap = std::find_if(node.rungs.begin(), node.rungs.end(), [&](const Rung& rung) {
      return rung.payload.bytes * kCoverBytesRatio <= below.bytes;
    });
    if (cheap == node.rungs.end()) return below;
    planned.cover_rung = static_cast<uint32_t>(cheap - node.rungs.begin());
    below.settled = true;
    return below;
  }

  template <typename Function>
  void forEachChild(const Node& node, Function&& function) const {
    for (unsigned octant = 0; octant < 8; ++octant)
      if ((node.child_mask >> octant & 1) != 0) function(*hierarchy_.find(node.key.child(octant)));
  }

  // ---- what is there

  bool ready(const Node& node, uint32_t rung) const {
    return node.rungs[rung].triangles == 0 || cache_.contains({node.key, rung});
  }

  /// The finest rung of a node that may be shown.
  uint32_t finestShown(const Node& node) const {
    if (options_.finer_stand_ins) return 0;
    const auto planned = plan_.find(node.key.value);
    return planned == plan_.end() ? 0 : planned->second.rung;
  }

  bool anyReady(const Node& node) const {
    for (uint32_t rung = finestShown(node); rung < node.rungs.size(); ++rung)
      if (ready(node, rung)) return true;
    return false;
  }

  bool expanded(const Node& node) const {
    const auto planned = plan_.find(node.key.value);
    return planned != plan_.end() && planned->second.role == Role::kExpanded;
  }

  bool near(const Node& node) const {
    const auto planned = plan_.find(node.key.value);
    return planned != plan_.end() ? planned->second.near : place(node).near;
  }

  /// True if resident meshes at the node, or at it and below, cover what of it is near the view.
  bool covered(const Node& node) { return anyReady(node) || !near(node) || childrenCovered(node); }

  bool childrenCovered(const Node& node) {
    if (node.isLeaf() || !hierarchy_.childrenKnown(node)) return false;
    if (!options_.finer_stand_ins && !expanded(node)) return false;
    const auto known = children_covered_.find(node.key.value);
    if (known != children_covered_.end()) return known->second;
    bool all = true;
    forEachChild(node, [&](const Node& child) { all = all && covered(child); });
    children_covered_[node.key.value] = all;
    return all;
  }

  // ---- the published cut; every function here is called for covered nodes only

  void show(const Node& node) {
    const auto planned = plan_.find(node.key.value);
    if (planned == plan_.end()) return showFiner(node);
    if (!planned->second.near && !anyReady(node)) return leaveOut(planned->second);
    switch (planned->second.role) {
      case Role::kExpanded:
        return showExpanded(planned->second);
      case Role::kBlocked:
        askForPage(planned->second, errorPx(planned->second, 0));
        return showPart(planned->second);
      case Role::kPart:
        return showPart(planned->second);
    }
  }

  /// A part that is not there and cannot be seen holds up nothing; it comes after all that is seen.
  void leaveOut(const Planned& planned) {
    whole_ = false;
    cut_->left_out.push_back(toModelBox(planned.node->box, step_));
    wishFor(planned, 0);
  }

  /// Asks for the wanted rung of a part. @param shown_px  error of what stands in for it.
  void wishFor(const Planned& part, float shown_px) {
    wish({part.node->key, part.rung}, part.near ? shown_px : errorPx(part, part.rung), part.near);
  }

  void showExpanded(const Planned& planned) {
    const Node& node = *planned.node;
    if (childrenCovered(node)) {
      for (uint32_t rung = 0; rung < node.rungs.size(); ++rung)
        if (cache_.contains({node.key, rung})) ancestors_.push_back({node.key, rung});
      forEachChild(node, [&](const Node& child) { show(child); });
      return;
    }
    uint32_t rung = 0;
    while (!ready(node, rung)) ++rung;
    emit(planned, rung);
    exact_ = false;
    ask(planned, errorPx(planned, rung));
  }

  /// Shows the wanted rung of a part or what stands in for it: a finer rung, finer nodes, a coarser rung.
  void showPart(const Planned& planned) {
    const Node& node = *planned.node;
    const uint32_t wanted = planned.rung;
    if (ready(node, wanted)) return emit(planned, wanted);
    (planned.near ? exact_ : whole_) = false;
    const bool is_blocked = planned.role == Role::kBlocked;
    for (uint32_t rung = wanted; rung-- > finestShown(node);) {
      if (!ready(node, rung)) continue;
      emit(planned, rung);
      if (!is_blocked) wishFor(planned, errorPx(planned, wanted));
      return;
    }
    if (planned.near && childrenCovered(node)) {
      if (!is_blocked) wishFor(planned, errorPx(planned, wanted));
      forEachChild(node, [&](const Node& child) { showFiner(child); });
      return;
    }
    uint32_t rung = wanted + 1;
    while (!ready(node, rung)) ++rung;
    emit(planned, rung);
    if (!is_blocked) wishFor(planned, errorPx(planned, rung));
  }

  /// Stands in for a wanted part above: the coarsest that is resident.
  void showFiner(const Node& node) {
    for (uint32_t rung = lastRung(node) + 1; rung-- > 0;)
      if (ready(node, rung)) return emit(place(node), rung);
    if (near(node)) return forEachChild(node, [&](const Node& child) { showFiner(child); });
    cut_->left_out.push_back(toModelBox(node.box, step_));
  }

  void emit(const Planned& planned, uint32_t rung) {
    const Rung& shown = planned.node->rungs[rung];
    if (shown.triangles == 0) return;
    const MeshKey key{planned.node->key, rung};
    in_use_.push_back(key);
    cut_->parts.push_back({key.node, rung, planned.visible, errorPx(planned, rung), cache_.find(key)});
    cut_->triangles += shown.triangles;
    cut_->blob_bytes += shown.payload.bytes;
    if (planned.visible) cut_->max_error_px = std::max(cut_->max_error_px, cut_->parts.back().error_px);
  }

  // ---- the wishes

  /// Asks for the wanted cut at and below a node, where something coarser is shown.
  /// @param shown_px  error of what is shown there, or will be by then.
  void ask(const Planned& planned, float shown_px) {
    const NodeKey key = planned.node->key;
    switch (planned.role) {
      case Role::kPart:
        return wishFor(planned, shown_px);
      case Role::kBlocked:
        return askForPage(planned, shown_px);
      case Role::kExpanded:
        break;
    }
    if (planned.cover_rung && !childrenCovered(*planned.node)) {
      const float cover_px = errorPx(planned, *planned.cover_rung);
      if (shown_px > 2 * cover_px) {
        wish({key, *planned.cover_rung}, shown_px, true);
        shown_px = cover_px;
      }
    }
    forEachChild(*planned.node, [&](const Node& child) { ask(plan_.at(child.key.value), shown_px); });
  }

  void askForPage(const Planned& planned, float shown_px) {
    const Node& node = *planned.node;
    const float priority_px = std::min(shown_px, std::numeric_limits<float>::max() / kPagePriorityFactor);
    wanted_.push_back({node.child_page,
                       {BlobKind::kPage, {node.key, 0}},
                       proto::WishClass::kVisible,
                       priority_px * kPagePriorityFactor});
  }

  void wish(MeshKey key, float priority_px, bool is_near) {
    const Rung& rung = hierarchy_.find(key.node)->rungs[key.rung];
    if (rung.triangles == 0) return;
    if (cache_.contains(key)) {
      in_use_.push_back(key);
      return;
    }
    wanted_.push_back({rung.payload,
                       {BlobKind::kMesh, key},
                       is_near ? proto::WishClass::kVisible : proto::WishClass::kMargin,
                       priority_px});
  }

  Refinement finish(bool has_cut) {
    std::sort(cut_->parts.begin(), cut_->parts.end(),
              [](const CutPart& a, const CutPart& b) { return a.node < b.node; });
    std::sort(wanted_.begin(), wanted_.end(), [](const Wish& a, const Wish& b) {
      if (a.wish_class != b.wish_class) return a.wish_class < b.wish_class;
      if (a.priority_px != b.priority_px) return a.priority_px > b.priority_px;
      return std::tie(a.use.mesh, a.use.kind) < std::tie(b.use.mesh, b.use.kind);
    });
    cut_->converged = exact_ && !blocked_ && !limited_;
    Refinement result;
    if (has_cut) result.cut = std::move(cut_);
    result.wanted = std::move(wanted_);
    result.in_use = std::move(in_use_);
    result.ancestors = std::move(ancestors_);
    result.limited = limited_;
    result.settled = exact_ && whole_ && !blocked_;
    return result;
  }

  const Hierarchy& hierarchy_;
  const MeshCache& cache_;
  const double step_;
  const AttributeSet attributes_;
  const View& view_;
  const RefineOptions& options_;

  std::unordered_map<uint64_t, Planned> plan_;
  std::priority_queue<Candidate> queue_;
  uint64_t triangles_ = 0, cut_bytes_ = 0;
  bool limited_ = false, blocked_ = false;
  std::unordered_map<uint64_t, bool> children_covered_;

  std::shared_ptr<Cut> cut_;
  bool exact_ = true;  // near the view the published cut is the wanted one
  bool whole_ = true;  // and elsewhere, with nothing left out
  std::vector<Wish> wanted_;
  std::vector<MeshKey> in_use_, ancestors_;
};

}  // namespace

Refinement refine(const Hierarchy& hierarchy, const MeshCache& cache, const Lattice& lattice,
                  AttributeSet attributes, const View& view, const RefineOptions& options) {
  return Run(hierarchy, cache, lattice, attributes, view, options).refine();
}

}  // namespace lode::core
