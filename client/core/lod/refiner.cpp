#include "client/core/lod/refiner.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <tuple>

#include "client/core/cache/mesh_cache.h"
#include "client/core/lod/part_error.h"
#include "client/core/lod/wanted_cut.h"

namespace lode::core {
namespace {

// Factor that puts pages before meshes: pages are small, and no blob below a node can be requested until the
// node's child page is loaded.
constexpr float kPagePriorityFactor = 16;
// Factor that puts blobs of hidden nodes after all visible blobs.
constexpr float kHiddenPriorityFactor = 1e-6f;
// A hidden node's coarsest LOD is requested as a stand-in if it has at most 1/2 of the bytes of the wanted
// parts at the node and below.
constexpr uint64_t kStandInBytesRatio = 2;

/// One refinement: builds the best cut that the resident meshes allow, and the requests for the rest.
class Run {
 public:
  Run(const KnownModel& model, const View& view, const RefineOptions& options, std::span<const HeldNode> held,
      const SeenPlaces* seen)
      : cache_(model.cache),
        step_(model.lattice_step),
        options_(options),
        seen_(seen),
        want_(model.hierarchy, model.lattice_step, model.attributes, view, options, held),
        may_leave_out_(cache_.lodsOf(kRootKey).any()),
        cut_(std::make_shared<Cut>()) {
    cut_->view = view;
    cut_->lattice_step = step_;
    cut_->threshold_px = options.threshold_px;
    cut_->parts.reserve(want_.nodes().size());
    in_use_.reserve(want_.nodes().size());
    for (WantedNode& wanted : want_.nodes()) {
      wanted.resident = &cache_.lodsOf(wanted.node->key);
      wanted.near |= !may_leave_out_;
    }
  }

  Refinement refine() {
    WantedNode& root = want_.root();
    const bool has_cut = root.near ? covered(root) : anyReady(root);
    if (has_cut) {
      show(root);
    } else {
      if (const auto coarsest = root.node->coarsestLod())
        request(root, *coarsest, std::numeric_limits<float>::max(), true);
      else
        askFor(root, std::numeric_limits<float>::max());
      exact_ = false;
    }
    return finish(has_cut);
  }

 private:
  // ---- resident meshes

  static bool ready(const WantedNode& wanted, uint32_t lod) {
    return wanted.node->lods[lod].triangles == 0 || wanted.resident->has(lod);
  }

  /// Returns the finest LOD of a wanted node that the options allow the cut to show.
  uint32_t finestShown(const WantedNode& wanted) const { return options_.finer_stand_ins ? 0 : wanted.lod; }

  bool anyReady(const WantedNode& wanted) const {
    for (uint32_t lod = finestShown(wanted); lod < wanted.node->lods.size(); ++lod)
      if (ready(wanted, lod)) return true;
    return false;
  }

  /// Wraps a node below the wanted cut, which may become a stand-in.
  WantedNode standIn(const KnownNode& node) const {
    WantedNode place = want_.place(node);
    place.resident = &cache_.lodsOf(node.key);
    place.lod = 0;
    place.near |= !may_leave_out_;
    return place;
  }

  /// Returns true if resident meshes of the node or of nodes below cover the node's region near the view.
  bool covered(WantedNode& wanted) { return anyReady(wanted) || !wanted.near || childrenCovered(wanted); }

  bool childrenCovered(WantedNode& wanted) {
    if (wanted.children_covered) return *wanted.children_covered;
    bool all = false;
    if (wanted.role == Role::kExpanded) {
      const auto children = want_.children(wanted);
      all =
          std::all_of(children.begin(), children.end(), [this](WantedNode& child) { return covered(child); });
    } else if (options_.finer_stand_ins) {
      all = finerChildrenCovered(*wanted.node);
    }
    wanted.children_covered = all;
    return all;
  }

  /// Returns childrenCovered() for a node below the wanted cut. Stops at the first uncovered node, so that
  /// the number of resident meshes limits the number of visited nodes.
  bool finerChildrenCovered(const KnownNode& node) {
    const auto children = node.knownChildren();
    return !children.empty() && std::all_of(children.begin(), children.end(), [this](const KnownNode& child) {
      const WantedNode place = standIn(child);
      return anyReady(place) || !place.near || finerChildrenCovered(child);
    });
  }

  // ---- occlusion

  bool isHidden(const WantedNode& wanted) const {
    return seen_ != nullptr && wanted.near && !seen_->in(wanted.node->key);
  }

  /// Returns the priority of a request for a node near the view. @param shown_px  projected error that the
  /// blob helps to remove.
  float priorityOf(float shown_px) const {
    return below_hidden_ ? shown_px * kHiddenPriorityFactor : shown_px;
  }

  // ---- the published cut; call all functions of this section only for covered nodes

  void show(WantedNode& wanted) {
    if (wanted.role == Role::kExpanded) return showExpanded(wanted);
    if (!wanted.near && !anyReady(wanted)) return leaveOut(wanted);
    below_hidden_ = (wanted.role == Role::kBlocked || !ready(wanted, wanted.lod)) && isHidden(wanted);
    if (wanted.role == Role::kBlocked) askForPage(wanted, want_.errorPx(wanted, 0));
    showPart(wanted);
    below_hidden_ = false;
  }

  /// Leaves out a missing part outside the view, so that the part delays no visible part. The part is
  /// requested after all visible blobs.
  void leaveOut(const WantedNode& wanted) {
    whole_ = false;
    uncovered_.push_back({wanted.node->key, toModelBox(wanted.node->box, step_)});
    if (wanted.role == Role::kBlocked) return askForPage(wanted, 0);
    request(wanted, 0);
  }

  // ---- fallbacks

  /// Sizes of the lists before the children of a node are added.
  struct Progress {
    size_t parts, uncovered, fallbacks;
  };
  Progress progress() const { return {cut_->parts.size(), uncovered_.size(), cut_->fallbacks.size()}; }

  /// Returns the finest resident LOD of a node that fits the fallback budgets. For the root, returns the
  /// coarsest resident LOD if none fits.
  std::optional<uint32_t> fallbackLod(const WantedNode& wanted) const {
    const MeshCache::Lods& resident = *wanted.resident;
    for (uint32_t lod = 0; lod < wanted.node->lods.size(); ++lod)
      if (resident.has(lod) &&
          fallback_bytes_ + meshBytes(*resident.mesh(lod)) <= options_.fallback_budget_bytes &&
          fallback_drawn_bytes_ + drawnBytes(*resident.mesh(lod)) <= options_.fallback_drawn_budget_bytes)
        return lod;
    if (wanted.node->key != kRootKey || !resident.any()) return std::nullopt;
    return resident.coarsest();
  }

  /// Makes a node the fallback for the nodes that were left out below it. Does nothing if none of its LODs
  /// fits the budgets; an ancestor then becomes the fallback.
  void addFallback(const WantedNode& wanted, const Progress& before) {
    if (uncovered_.size() == before.uncovered) return;
    const std::optional<uint32_t> lod = fallbackLod(wanted);
    if (!lod) return;
    in_use_.push_back({wanted.node->key, *lod});
    Fallback fallback;
    fallback.part = partAt(wanted, *lod, Fit::kCoarser);
    fallback.part.visible = false;
    fallback_bytes_ += meshBytes(*fallback.part.mesh);
    const uint64_t drawn_bytes = drawnBytes(*fallback.part.mesh);
    fallback_drawn_bytes_ += drawn_bytes;
    cut_->drawn_bytes += drawn_bytes;
    fallback.first_part = static_cast<uint32_t>(before.parts);
    fallback.end_part = static_cast<uint32_t>(cut_->parts.size());
    fallback.first_left_out = static_cast<uint32_t>(cut_->left_out.size());
    const auto first = uncovered_.begin() + static_cast<std::ptrdiff_t>(before.uncovered);
    cut_->left_out.insert(cut_->left_out.end(), first, uncovered_.end());
    uncovered_.erase(first, uncovered_.end());
    fallback.end_left_out = static_cast<uint32_t>(cut_->left_out.size());
    fallback.first_nested = static_cast<uint32_t>(before.fallbacks);
    cut_->fallbacks.push_back(std::move(fallback));
  }

  /// Requests the wanted LOD of a part. @param shown_px  projected error of the stand-in shown until the
  /// wanted LOD arrives.
  void request(const WantedNode& part, float shown_px) {
    request(part, part.lod, part.near ? priorityOf(shown_px) : want_.errorPx(part, part.lod), part.near);
  }

  void showExpanded(WantedNode& wanted) {
    const Node& node = *wanted.node;
    if (childrenCovered(wanted)) {
      for (uint32_t lod = 0; lod < node.lods.size(); ++lod)
        if (wanted.resident->has(lod)) ancestors_.push_back({node.key, lod});
      const Progress before = progress();
      for (WantedNode& child : want_.children(wanted)) show(child);
      return addFallback(wanted, before);
    }
    exact_ = false;
    uint32_t lod = finestShown(wanted);
    while (lod < wanted.node->lods.size() && !ready(wanted, lod)) ++lod;
    if (lod == wanted.node->lods.size()) return leaveOut(wanted);
    emit(wanted, lod, Fit::kCoarser);
    ask(wanted, want_.errorPx(wanted, lod));
  }

  /// Shows the wanted LOD of a part. If it is missing, shows a finer LOD, finer nodes or a coarser LOD, in
  /// this order.
  void showPart(WantedNode& part) {
    const uint32_t wanted = part.lod;
    const bool is_blocked = part.role == Role::kBlocked;
    const bool is_for_the_view = part.visible && !is_blocked;
    if (ready(part, wanted)) return emit(part, wanted, is_for_the_view ? Fit::kWanted : Fit::kCoarser);
    (part.near ? exact_ : whole_) = false;
    for (uint32_t lod = wanted; lod-- > finestShown(part);) {
      if (!ready(part, lod)) continue;
      emit(part, lod, Fit::kFiner);
      if (!is_blocked) request(part, want_.errorPx(part, wanted));
      return;
    }
    if (part.near && childrenCovered(part)) {
      if (!is_blocked) request(part, want_.errorPx(part, wanted));
      const Progress before = progress();
      showFinerChildren(*part.node);
      return addFallback(part, before);
    }
    uint32_t lod = wanted + 1;
    while (!ready(part, lod)) ++lod;
    emit(part, lod, Fit::kCoarser);
    if (!is_blocked) request(part, want_.errorPx(part, lod));
  }

  void showFinerChildren(const KnownNode& node) {
    if (node.child_page) pages_.push_back(node.key);
    for (const KnownNode& child : node.knownChildren()) showFiner(child);
  }

  /// Shows the coarsest resident LOD of a node below a wanted part, or the node's children if no LOD is
  /// resident.
  void showFiner(const KnownNode& node) {
    const WantedNode place = standIn(node);
    for (uint32_t lod = WantedCut::lastLod(node) + 1; lod-- > 0;)
      if (ready(place, lod)) return emit(place, lod, Fit::kFiner);
    if (place.near) return showFinerChildren(node);
    uncovered_.push_back({node.key, toModelBox(node.box, step_)});
  }

  /// Relation of a shown part to the wanted part that it represents.
  enum class Fit { kWanted, kFiner, kCoarser };

  float thresholdOf(float error_px, Fit fit) const {
    if (fit == Fit::kWanted) return options_.threshold_px;
    return fit == Fit::kFiner ? std::min(options_.threshold_px, error_px)
                              : std::max(options_.threshold_px, error_px);
  }

  /// Returns the part for a resident mesh. Computes the error in pixels from the distance to the mesh. The
  /// wanted cut uses the distance to the node's box instead, because it must not depend on the resident
  /// meshes.
  CutPart partAt(const WantedNode& wanted, uint32_t lod, Fit fit) const {
    const Lod& shown = wanted.node->lods[lod];
    CutPart part;
    part.node = wanted.node->key;
    part.lod = lod;
    part.visible = wanted.visible;
    part.mesh = wanted.resident->mesh(lod);
    part.error_model = shown.error_model;
    part.off_model = shown.offModel();
    part.box = toModelBox(wanted.node->box, step_);
    part.error_px = wanted.visible ? partErrorPx(part, step_, want_.frustum()) : want_.errorPx(wanted, lod);
    part.threshold_px = thresholdOf(part.error_px, fit);
    return part;
  }

  void emit(const WantedNode& part, uint32_t lod, Fit fit) {
    const Lod& shown = part.node->lods[lod];
    if (shown.triangles == 0) return;
    const MeshKey key{part.node->key, lod};
    in_use_.push_back(key);
    cut_->parts.push_back(partAt(part, lod, fit));
    const float error_px = cut_->parts.back().error_px;
    cut_->drawn_bytes += drawnBytes(*cut_->parts.back().mesh);
    cut_->triangles += shown.triangles;
    cut_->blob_bytes += shown.payload.bytes;
    if (!part.visible) return;
    cut_->max_error_px = std::max(cut_->max_error_px, error_px);
    if (part.node->finerLod(lod) || part.node->isReplaceable())
      cut_->refinable_px = std::max(cut_->refinable_px, error_px);
  }

  // ---- the requests

  /// Requests the missing parts of the wanted cut at and below a node for which a coarser stand-in is shown.
  /// @param shown_px  projected error of the stand-in that is shown until the requests are answered.
  void ask(WantedNode& wanted, float shown_px) {
    const bool begins = !below_hidden_ && isHidden(wanted) && (covered(wanted) || standInIsCheap(wanted));
    if (begins && !covered(wanted))
      request(wanted, WantedCut::coarsestLod(*wanted.node), shown_px, true, true);
    below_hidden_ |= begins;
    askFor(wanted, shown_px);
    if (begins) below_hidden_ = false;
  }

  /// Returns true if a hidden node's coarsest LOD is worth loading before all visible blobs are resident.
  static bool standInIsCheap(const WantedNode& wanted) {
    const uint64_t stand_in_bytes = wanted.node->lods.back().payload.bytes;
    return wanted.role == Role::kBlocked || wanted.below_bytes >= kStandInBytesRatio * stand_in_bytes;
  }

  void askFor(WantedNode& wanted, float shown_px) {
    switch (wanted.role) {
      case Role::kPart:
        return request(wanted, shown_px);
      case Role::kBlocked:
        return askForPage(wanted, shown_px);
      case Role::kExpanded:
        break;
    }
    if (wanted.cover_lod && !childrenCovered(wanted)) {
      const float cover_px = want_.errorPx(wanted, *wanted.cover_lod);
      if (shown_px > 2 * cover_px) {
        request(wanted, *wanted.cover_lod, priorityOf(shown_px), true);
        shown_px = cover_px;
      }
    }
    for (WantedNode& child : want_.children(wanted)) ask(child, shown_px);
  }

  void askForPage(const WantedNode& wanted, float shown_px) {
    const Node& node = *wanted.node;
    const float priority_px =
        std::min(priorityOf(shown_px), std::numeric_limits<float>::max() / kPagePriorityFactor);
    wanted_.push_back({node.child_page,
                       {BlobKind::kPage, {node.key, 0}},
                       proto::RequestClass::kVisible,
                       priority_px * kPagePriorityFactor});
  }

  void request(const WantedNode& wanted, uint32_t number, float priority_px, bool is_near,
               bool is_stand_in = false) {
    const Lod& lod = wanted.node->lods[number];
    const MeshKey key{wanted.node->key, number};
    if (lod.triangles == 0) return;
    if (wanted.resident->has(number)) {
      in_use_.push_back(key);
      return;
    }
    wanted_.push_back({lod.payload,
                       {BlobKind::kMesh, key},
                       is_near ? proto::RequestClass::kVisible : proto::RequestClass::kMargin,
                       priority_px,
                       is_stand_in});
  }

  Refinement finish(bool has_cut) {
    std::sort(wanted_.begin(), wanted_.end(), [](const Request& a, const Request& b) {
      if (a.request_class != b.request_class) return a.request_class < b.request_class;
      if (a.priority_px != b.priority_px) return a.priority_px > b.priority_px;
      return std::tie(a.use.mesh, a.use.kind) < std::tie(b.use.mesh, b.use.kind);
    });
    cut_->converged = exact_ && !want_.blocked() && !want_.limited() && !want_.stoppedByLoss();
    Refinement result;
    if (has_cut) result.cut = std::move(cut_);
    result.wanted = std::move(wanted_);
    result.in_use = std::move(in_use_);
    result.ancestors = std::move(ancestors_);
    result.pages = std::move(pages_);
    result.pages.insert(result.pages.end(), want_.pages().begin(), want_.pages().end());
    if (options_.hysteresis_factor < 1) result.held = want_.held();
    if (options_.shares_memory) result.wanted_meshes = want_.meshes();
    result.limited = want_.limited();
    result.settled = exact_ && whole_ && !want_.blocked();
    return result;
  }

  const MeshCache& cache_;
  const double step_;
  const RefineOptions& options_;
  const SeenPlaces* const seen_;
  WantedCut want_;
  const bool may_leave_out_;  // the root is resident and can serve as fallback

  std::shared_ptr<Cut> cut_;
  std::vector<LeftOut> uncovered_;  // left-out nodes that have no fallback yet
  uint64_t fallback_bytes_ = 0, fallback_drawn_bytes_ = 0;
  bool exact_ = true;          // the published cut equals the wanted cut near the view
  bool whole_ = true;          // no part is left out
  bool below_hidden_ = false;  // the current node is hidden or lies below a hidden node
  std::vector<Request> wanted_;
  std::vector<MeshKey> in_use_, ancestors_;
  std::vector<NodeKey> pages_;  // owners of pages that only stand-ins need
};

}  // namespace

Refinement refine(const KnownModel& model, const View& view, const RefineOptions& options,
                  std::span<const HeldNode> held, const SeenPlaces* seen) {
  if (!model.hierarchy.root()) return {};
  return Run(model, view, options, held, seen).refine();
}

}  // namespace lode::core
