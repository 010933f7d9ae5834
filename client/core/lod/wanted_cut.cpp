#include "client/core/lod/wanted_cut.h"

#include <algorithm>
#include <limits>

#include "client/core/cache/mesh_cache.h"

namespace lode::core {
namespace {

constexpr size_t kUsualNodes = 8192;       // number of nodes for which memory is reserved
constexpr uint64_t kCoverBytesRatio = 20;  // a covering step costs at most 1/20 of the bytes wanted below it

uint64_t partBytes(const Lod& lod, AttributeSet attributes) {
  return kPartBytes + (lod.triangles == 0 ? 0 : meshBytes(lod.vertices, lod.triangles, attributes));
}

}  // namespace

void WantedCut::Totals::add(const Lod& lod, AttributeSet attributes) {
  triangles += lod.triangles;
  bytes += partBytes(lod, attributes);
  drawn_bytes += drawnBytes(lod.vertices, lod.triangles, attributes);
}

void WantedCut::Totals::remove(const Lod& lod, AttributeSet attributes) {
  triangles -= lod.triangles;
  bytes -= partBytes(lod, attributes);
  drawn_bytes -= drawnBytes(lod.vertices, lod.triangles, attributes);
}

WantedCut::WantedCut(const Hierarchy& hierarchy, double lattice_step, AttributeSet attributes,
                     const View& view, const RefineOptions& options, std::span<const HeldNode> held)
    : hierarchy_(hierarchy),
      step_(lattice_step),
      attributes_(attributes),
      frustum_(view, kMarginWidening),
      options_(options),
      held_(options.hysteresis_factor < 1 ? held : std::span<const HeldNode>()) {
  nodes_.reserve(kUsualNodes);
  begin();
  refine();
  if (stopped_) {
    is_best_first_ = true;
    begin();
    refine();
  }
  chooseCovers(root());
}

void WantedCut::begin() {
  const KnownNode& first = *hierarchy_.root();
  nodes_.clear();
  open_.clear();
  pages_.clear();
  page_bytes_ = hierarchy_.rootPageBytes();
  stopped_ = limited_ = blocked_ = stopped_by_loss_ = false;
  totals_ = {};
  nodes_.push_back(place(first));
  totals_.add(first.lods[root().lod], attributes_);
  nodes_.back().held = held_.empty() ? 0 : 1;
  enqueue(0);
}

WantedNode WantedCut::place(const KnownNode& node, bool in_sight) const {
  WantedNode wanted;
  wanted.node = &node;
  wanted.lod = coarsestLod(node);
  if (node.box.empty()) return wanted;
  const ModelBox box = toModelBox(node.box, step_);
  const Visibility seen = in_sight ? Visibility::kInside : frustum_.test(box);
  wanted.visible = seen != Visibility::kOutside;
  wanted.wholly_visible = seen == Visibility::kInside;
  wanted.near = wanted.visible || frustum_.isInMargin(box);
  wanted.distance_model = frustum_.distanceTo(box);
  return wanted;
}

float WantedCut::errorPx(const WantedNode& wanted, uint32_t lod) const {
  return frustum_.errorPx(wanted.node->lods[lod].offModel(), wanted.distance_model);
}

void WantedCut::enqueue(uint32_t place) {
  const WantedNode& wanted = nodes_[place];
  const bool must_replace = !wanted.node->coarsestLod();
  if (!wanted.visible && !must_replace) return;
  const float error_px = must_replace ? std::numeric_limits<float>::infinity() : errorPx(wanted, wanted.lod);
  const bool is_too_coarse =
      error_px > options_.threshold_px ||
      (error_px > options_.threshold_px * options_.hysteresis_factor && wasFiner(wanted));
  if (!is_too_coarse) return;
  open_.push_back({error_px, place, wanted.node->key});
  if (is_best_first_) std::push_heap(open_.begin(), open_.end());
}

WantedCut::Candidate WantedCut::takeNext() {
  if (is_best_first_) std::pop_heap(open_.begin(), open_.end());
  const Candidate next = open_.back();
  open_.pop_back();
  return next;
}

bool WantedCut::wasFiner(const WantedNode& wanted) const {
  if (wanted.held == 0) return false;
  const HeldNode& held = held_[wanted.held - 1];
  return held.first_child != 0 || held.lod < wanted.lod;
}

void WantedCut::refine() {
  while (!open_.empty())
    if (!replacePart(takeNext()) || (stopped_ && !is_best_first_)) return;
}

/// Replaces a part by its next finer LOD or its children. @return false if the budget of triangles, memory or
/// GPU memory does not allow the replacement.
bool WantedCut::replacePart(const Candidate& candidate) {
  WantedNode& wanted = nodes_[candidate.place];
  const KnownNode& node = *wanted.node;
  Totals totals = totals_;
  totals.remove(node.lods[wanted.lod], attributes_);
  if (const std::optional<uint32_t> finer = node.finerLod(wanted.lod)) {
    totals.add(node.lods[*finer], attributes_);
    if (!fits(candidate, totals)) return false;
    wanted.lod = *finer;
    enqueue(candidate.place);
    return true;
  }
  if (!node.isReplaceable()) {
    stopped_by_loss_ |= candidate.error_px > options_.threshold_px && (wanted.lod > 0 || !node.isLeaf());
    return true;
  }
  const uint64_t page_bytes =
      node.childrenKnown() ? node.page_below_bytes : pageBytesAtMost(node.child_page.bytes);
  if (page_bytes_ + page_bytes > options_.hierarchy_budget_bytes) {
    stopAt(candidate);
    return true;
  }
  if (node.childrenKnown()) return expand(candidate, totals);
  wanted.role = Role::kBlocked;
  blocked_ = true;
  page_bytes_ += page_bytes;
  return true;
}

bool WantedCut::expand(const Candidate& candidate, const Totals& without) {
  const uint32_t place = candidate.place;
  const KnownNode& node = *nodes_[place].node;
  const auto children = node.knownChildren();
  const auto first_child = static_cast<uint32_t>(nodes_.size());
  const uint32_t held = nodes_[place].held;
  const uint32_t held_child = held == 0 ? 0 : held_[held - 1].first_child;
  const bool in_sight = nodes_[place].wholly_visible;
  Totals totals = without;
  for (uint32_t i = 0; i < children.size(); ++i) {
    WantedNode& child = nodes_.emplace_back(this->place(children[i], in_sight));
    child.held = held_child == 0 ? 0 : held_child + i + 1;  // index in held_ plus 1
    if (child.visible) skipWorse(child, candidate.error_px);
    totals.add(children[i].lods[child.lod], attributes_);
  }
  if (!fits(candidate, totals)) {
    nodes_.resize(first_child);
    return false;
  }
  if (node.child_page) {
    page_bytes_ += node.page_below_bytes;
    pages_.push_back(node.key);
  }
  nodes_[place].role = Role::kExpanded;
  nodes_[place].first_child = first_child;
  for (uint32_t child = first_child; child < nodes_.size(); ++child) enqueue(child);
  return true;
}

/// Refines a child to the coarsest LOD whose error does not exceed the error of the part that the child
/// replaces.
void WantedCut::skipWorse(WantedNode& wanted, float replaced_px) const {
  for (auto finer = wanted.node->finerLod(wanted.lod); finer && errorPx(wanted, wanted.lod) > replaced_px;
       finer = wanted.node->finerLod(wanted.lod))
    wanted.lod = *finer;
}

bool WantedCut::fits(const Candidate& candidate, const Totals& totals) {
  const bool fits = totals.triangles <= options_.triangle_budget &&
                    totals.bytes <= options_.cut_budget_bytes &&
                    totals.drawn_bytes <= options_.drawn_budget_bytes;
  if (fits) totals_ = totals;
  if (!fits) stopAt(candidate);
  return fits;
}

/// Notes that a budget stopped the refinement of a part. The cut is limited only if such a part exceeds the
/// threshold, not if hysteresis alone would refine it.
void WantedCut::stopAt(const Candidate& candidate) {
  stopped_ = true;
  limited_ |= candidate.error_px > options_.threshold_px;
}

/// Chooses the covering step (see refine()). On each path from the root, selects the deepest expanded node
/// that has an LOD with a payload much smaller than the wanted payloads below. Of this node, selects the
/// finest such LOD. The choice ignores which meshes are resident, so that requests do not oscillate.
WantedCut::Below WantedCut::chooseCovers(WantedNode& wanted) {
  const KnownNode& node = *wanted.node;
  if (wanted.role == Role::kPart) {
    wanted.below_bytes = wanted.near ? node.lods[wanted.lod].payload.bytes : 0;
    return {wanted.below_bytes, false};
  }
  if (wanted.role == Role::kBlocked) return {0, true};
  Below below;
  for (WantedNode& child : children(wanted)) {
    const Below more = chooseCovers(child);
    below.bytes += more.bytes;
    below.settled |= more.settled;
  }
  wanted.below_bytes = below.bytes;
  if (below.settled) return below;
  for (uint32_t lod = 0; lod < node.lods.size() && !below.settled; ++lod) {
    if (node.isLost(lod) || node.lods[lod].payload.bytes * kCoverBytesRatio > below.bytes) continue;
    wanted.cover_lod = lod;
    below.settled = true;
  }
  return below;
}

std::vector<HeldNode> WantedCut::held() const {
  std::vector<HeldNode> held;
  held.reserve(nodes_.size());
  for (const WantedNode& wanted : nodes_) held.push_back({wanted.first_child, wanted.lod});
  return held;
}

std::vector<WantedMesh> WantedCut::meshes() const {
  std::vector<WantedMesh> meshes;
  for (const WantedNode& wanted : nodes_) {
    const Lod& lod = wanted.node->lods[wanted.lod];
    if (wanted.role == Role::kExpanded || lod.triangles == 0) continue;
    meshes.push_back({{wanted.node->key, wanted.lod},
                      meshBytes(lod.vertices, lod.triangles, attributes_),
                      drawnBytes(lod.vertices, lod.triangles, attributes_)});
  }
  return meshes;
}

}  // namespace lode::core
