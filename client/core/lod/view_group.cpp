#include "client/core/lod/view_group.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "client/core/lod/cut.h"

namespace lode::core {
namespace {

constexpr uint64_t kFinerRatio = 2;     // growth of the triangle count that triggers a new occlusion estimate
constexpr uint64_t kFallbackShare = 8;  // fallbacks get 1/8 of the mesh budget and of the drawn budget
constexpr uint64_t kReserveShare = 4;   // 1/4 of a budget must be free before a degradation is undone
constexpr float kStepsOfTwo = 4;        // the threshold is raised in steps of 2^1/4
constexpr int kMostCoarsening = 80;  // largest number of steps, which raise the threshold by the factor 2^20

/// @param with_reserve  true requires that 1/kReserveShare of the budget stays free.
bool hasRoom(uint64_t bytes, uint64_t budget_bytes, bool with_reserve) {
  return bytes <= budget_bytes - (with_reserve ? budget_bytes / kReserveShare : 0);
}

}  // namespace

ViewGroup::ViewGroup(const RefineOptions& options) : options_(options) {
  setDrawnBudget(options.drawn_budget_bytes);
}

void ViewGroup::setDrawnBudget(uint64_t bytes) noexcept {
  drawn_budget_bytes_ = bytes;
  options_.fallback_drawn_budget_bytes = bytes / kFallbackShare;
  options_.drawn_budget_bytes = bytes - options_.fallback_drawn_budget_bytes;
  views_changed_ = true;
}

void ViewGroup::setViews(std::span<const View> views, float threshold_px) {
  const bool is_same_count = views_.size() == views.size();
  const bool is_same_threshold = options_.threshold_px == threshold_px;
  views_.resize(views.size());
  for (size_t number = 0; number < views.size(); ++number) {
    ViewState& state = views_[number];
    if (is_same_count && is_same_threshold && state.view == views[number]) continue;
    state.view = views[number];
    state.seen.reset();
    state.seen_triangles = 0;
    views_changed_ = true;
  }
  options_.threshold_px = threshold_px;
}

void ViewGroup::forgetModel() noexcept {
  model_version_ = 0;
  settled_ = limited_ = false;
  degradation_ = Degradation::kNone;
  coarsening_ = 0;
  requests_.clear();
  pages_.clear();
  for (ViewState& state : views_) {
    state.held.clear();
    state.seen.reset();
    state.seen_triangles = 0;
  }
}

const std::shared_ptr<const Cut>& ViewGroup::cut() const noexcept {
  static const std::shared_ptr<const Cut> kNone;
  return view_cuts_ ? view_cuts_->all : kNone;
}

/// Estimates which nodes are occluded in a view, and again when the cut's triangle count has doubled. Does
/// nothing if the cut has converged, or is too large to rasterise.
/// @return true if there is a new estimate.
bool ViewGroup::updateOcclusion(ViewState& state, const Cut& cut, const ModelSummary& model) {
  if (cut.converged || cut.triangles < kFinerRatio * state.seen_triangles ||
      cut.triangles > SeenPlaces::kMostTriangles)
    return false;
  state.seen = SeenPlaces::of(cut, model);
  state.seen_triangles = cut.triangles;
  return state.seen.has_value();
}

ViewGroup::Gathered ViewGroup::refineWith(const Model& model, const RefineOptions& options) const {
  Gathered gathered;
  std::vector<std::shared_ptr<const Cut>> cuts;
  for (const ViewState& state : views_) {
    const SeenPlaces* const seen = state.seen ? &*state.seen : nullptr;
    gathered.refinements.push_back(core::refine(
        {model.hierarchy(), model.meshes(), model.summary().lattice.step, model.summary().attributes},
        state.view, options, state.held, seen));
    if (const auto& cut = gathered.refinements.back().cut) cuts.push_back(cut);
  }
  if (cuts.size() < views_.size()) return gathered;
  gathered.all = cuts.size() == 1 ? gathered.refinements.front().cut : gatherMeshes(cuts);
  return gathered;
}

RefineOptions ViewGroup::optionsAt(Degradation degradation) const {
  RefineOptions options = options_;
  options.threshold_px *= std::exp2(static_cast<float>(coarsening_) / kStepsOfTwo);
  if (degradation >= Degradation::kNoFallbacks) options.fallback_budget_bytes = 0;
  options.finer_stand_ins = degradation < Degradation::kNoFinerStandIns;
  return options;
}

ViewGroup::Wanted ViewGroup::wantedBy(const Gathered& gathered) {
  Wanted wanted;
  std::set<MeshKey> counted;
  for (const Refinement& refinement : gathered.refinements) {
    wanted.limited = wanted.limited || refinement.limited;
    for (const WantedMesh& mesh : refinement.wanted_meshes) {
      wanted.bytes += kPartBytes;
      if (!counted.insert(mesh.key).second) continue;
      wanted.bytes += mesh.bytes;
      wanted.drawn_bytes += mesh.drawn_bytes;
    }
  }
  return wanted;
}

/// Returns true if the wanted cuts of all views fit the budgets.
bool ViewGroup::fits(const Wanted& wanted, bool with_reserve) const noexcept {
  return !wanted.limited && hasRoom(wanted.bytes, options_.cut_budget_bytes, with_reserve) &&
         hasRoom(wanted.drawn_bytes, options_.drawn_budget_bytes, with_reserve);
}

/// Refines all views with one threshold: the requested threshold, or the smallest threshold that fits the
/// budgets. Lowers a raised threshold only if a reserve stays free, so that the threshold does not oscillate.
ViewGroup::Gathered ViewGroup::refineWithin(const Model& model) {
  const auto refineNow = [&] {
    RefineOptions options = optionsAt(Degradation::kNone);
    options.shares_memory = usesOneThreshold();
    return refineWith(model, options);
  };
  if (!usesOneThreshold()) coarsening_ = 0;
  Gathered gathered = refineNow();
  Wanted wanted = wantedBy(gathered);
  while (usesOneThreshold() && !fits(wanted, false) && coarsening_ < kMostCoarsening) {
    ++coarsening_;
    gathered = refineNow();
    wanted = wantedBy(gathered);
  }
  while (coarsening_ > 0) {
    --coarsening_;
    Gathered finer = refineNow();
    const Wanted wanted_finer = wantedBy(finer);
    if (!fits(wanted_finer, true)) {
      ++coarsening_;
      break;
    }
    gathered = std::move(finer);
    wanted = wanted_finer;
  }
  wanted_bytes_ = wanted.bytes;
  if (coarsening_ == 0) return gathered;
  // Estimate the memory: halving the threshold quadruples the triangles, at most up to the original number.
  const uint64_t triangles = model.summary().triangles;
  const double most_bytes =
      std::max(static_cast<double>(wanted.bytes),
               static_cast<double>(meshBytes(triangles / 2, triangles, model.summary().attributes)));
  const double estimate = static_cast<double>(wanted.bytes) * std::exp2(2.0 * coarsening_ / kStepsOfTwo);
  wanted_bytes_ = static_cast<uint64_t>(std::min(estimate, most_bytes));
  return gathered;
}

/// Marks the pages and meshes in use, and evicts unused pages if memory is short.
/// @return true if everything in use fits the memory and drawn budgets.
bool ViewGroup::keep(Model& model, const Gathered& gathered, bool with_reserve) const {
  std::vector<NodeKey> pages;
  std::vector<MeshKey> in_use, ancestors;
  for (const Refinement& refinement : gathered.refinements) {
    pages.insert(pages.end(), refinement.pages.begin(), refinement.pages.end());
    in_use.insert(in_use.end(), refinement.in_use.begin(), refinement.in_use.end());
    ancestors.insert(ancestors.end(), refinement.ancestors.begin(), refinement.ancestors.end());
  }
  model.hierarchy().use(pages, model.hierarchyBudgetBytes());
  const uint64_t used_bytes = model.meshes().use(in_use, ancestors);
  return hasRoom(used_bytes, model.meshes().budgetBytes(), with_reserve) &&
         model.hierarchy().bytes() <= model.hierarchyBudgetBytes() &&
         (!gathered.all || hasRoom(gathered.all->drawn_bytes, drawn_budget_bytes_, with_reserve));
}

/// If memory is short, drops first the fallbacks, then also the stand-ins that are finer than the wanted
/// parts. Restores them only if a reserve stays free or the cuts have settled, so that one arriving mesh does
/// not change the whole cut.
void ViewGroup::fit(Model& model, Gathered& gathered) {
  const Degradation before = degradation_;
  degradation_ = Degradation::kNone;
  while (!keep(model, gathered, degradation_ < before) && degradation_ != Degradation::kNoFinerStandIns) {
    degradation_ =
        degradation_ == Degradation::kNone ? Degradation::kNoFallbacks : Degradation::kNoFinerStandIns;
    gathered = refineWith(model, optionsAt(degradation_));
  }
  const auto isSettled = [](const Refinement& refinement) { return refinement.settled; };
  if (std::ranges::all_of(gathered.refinements, isSettled)) degradation_ = Degradation::kNone;
}

bool ViewGroup::refine(Model& model) {
  if (views_.empty() || !model.hierarchy().root()) return false;
  if (!views_changed_ && model_version_ == model.version()) return false;
  views_changed_ = false;
  model_version_ = model.version();
  // The wanted cuts may use half of the mesh budget. The other half is for the shown cuts, so that neither
  // kind of cut blocks the other.
  options_.hierarchy_budget_bytes = model.hierarchyBudgetBytes();
  options_.cut_budget_bytes = model.meshes().budgetBytes() / 2;
  options_.fallback_budget_bytes = model.meshes().budgetBytes() / kFallbackShare;
  Gathered gathered = refineWithin(model);
  // Estimate occlusion only for a single view. With several views, other instances hide most of the hidden
  // nodes, and the estimate ignores them.
  if (views_.size() == 1 && gathered.all && updateOcclusion(views_.front(), *gathered.all, model.summary()))
    gathered = refineWith(model, optionsAt(Degradation::kNone));
  fit(model, gathered);
  model.meshes().trim();
  publish(model, gathered);
  return true;
}

/// Returns true if cuts of a replaced build stay: they are for the current views, and sharper than the new
/// cuts, which are still being refined.
bool ViewGroup::keepsReplaced(const Model& model, const Cut& all) const {
  if (!view_cuts_ || cut_build_ == model.build() || settled_ || view_cuts_->cuts.size() != views_.size())
    return false;
  for (size_t number = 0; number < views_.size(); ++number)
    if (view_cuts_->cuts[number]->view != views_[number].view) return false;
  return all.max_error_px > view_cuts_->all->max_error_px;
}

/// Publishes the cuts and requests of a refinement.
void ViewGroup::publish(Model& model, Gathered& gathered) {
  settled_ = true;
  limited_ = coarsening_ > 0;
  pages_.clear();
  std::vector<std::vector<Request>> requests;
  for (size_t number = 0; number < views_.size(); ++number) {
    Refinement& refinement = gathered.refinements[number];
    settled_ = settled_ && refinement.settled;
    limited_ = limited_ || refinement.limited;
    views_[number].held = std::move(refinement.held);
    pages_.insert(pages_.end(), refinement.pages.begin(), refinement.pages.end());
    requests.push_back(std::move(refinement.wanted));
  }
  requests_ = mergeRequests(requests);
  if (gathered.all && !keepsReplaced(model, *gathered.all)) {
    cut_build_ = model.build();
    for (const Refinement& refinement : gathered.refinements) label(*refinement.cut);
    label(*gathered.all);
    if (model.textures()) addTextures(*gathered.all, gathered.refinements, model);
    auto view_cuts = std::make_shared<ViewCuts>();
    for (Refinement& refinement : gathered.refinements) view_cuts->cuts.push_back(std::move(refinement.cut));
    view_cuts->all = std::move(gathered.all);
    view_cuts_ = std::move(view_cuts);
  }
  if (!model.textures()) return;
  const std::vector<Request>& missing = model.textures()->missing();
  requests_.insert(requests_.end(), missing.begin(), missing.end());
  std::stable_sort(requests_.begin(), requests_.end(), [](const Request& a, const Request& b) {
    if (a.request_class != b.request_class) return a.request_class < b.request_class;
    return a.priority_px > b.priority_px;
  });
}

/// Sets the build and the threshold of a cut. Marks a cut at a raised threshold as not converged.
void ViewGroup::label(Cut& cut) const {
  cut.build = cut_build_;
  cut.threshold_px = options_.threshold_px;
  cut.converged = cut.converged && coarsening_ == 0;
}

/// Requests the tiles that the cuts need, and adds the resident tiles to the union of the cuts.
void ViewGroup::addTextures(Cut& all, std::span<const Refinement> refinements, Model& model) {
  TextureStream& textures = *model.textures();
  const double step = model.summary().lattice.step;
  const std::shared_ptr<const TextureSet>& set = textures.set();
  std::vector<TexturedPart> parts;
  for (size_t place = 0; set && place < refinements.size(); ++place) {
    const Cut& cut = *refinements[place].cut;
    for (size_t number = 0; number < partCount(cut); ++number) {
      const CutPart& part = partOf(cut, number);
      const MeshKey key{part.node, part.lod};
      if (model.meshes().footprint(key) == nullptr)  // the mesh was decoded before the texture set arrived
        model.meshes().setFootprint(
            key, std::make_shared<const TextureFootprint>(makeFootprint(*part.mesh, *set, step)));
      const ModelBox box = toModelBox(model.hierarchy().find(part.node)->box, step);
      const double distance_model = distanceToBox(views_[place].view.eye_model, box);
      parts.push_back({model.meshes().footprint(key), distance_model, part.visible});
    }
  }
  textures.refine(parts, views_.front().view, options_.threshold_px);
  all.textures = set;
  all.tiles = textures.residentTiles();
  all.blob_bytes += textures.blobBytesInUse();
  settled_ = settled_ && textures.complete();
  all.converged = all.converged && textures.complete();
  all.lost_tiles = textures.lostCount();
}

}  // namespace lode::core
