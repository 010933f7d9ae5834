#include "client/core/lod/view_group.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "client/core/lod/cut.h"

namespace lode::core {
namespace {

constexpr uint64_t kFinerRatio = 2;  // of a cut's triangles, from which on it is worth to look anew
// One in so many bytes of the meshes, and of what may be drawn, is for fallbacks.
constexpr uint64_t kFallbackShare = 8;
constexpr uint64_t kSpareShare = 4;  // one in so many bytes is free before what was given up comes back
constexpr float kStepsOfTwo = 4;     // the threshold is raised by steps of 2^1/4,
constexpr int kMostCoarsening = 80;  // to a million times at most

/// @param to_spare  with a part more.
bool hasRoom(uint64_t bytes, uint64_t budget_bytes, bool to_spare) {
  return bytes <= budget_bytes - (to_spare ? budget_bytes / kSpareShare : 0);
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
  giving_ = Giving::kNothing;
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

/// Where something is missing: at once, and again whenever the cut has become finer.
/// @return whether more is known than before.
bool ViewGroup::lookAtWhatIsSeen(ViewState& state, const Cut& cut, const ModelSummary& model) {
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
    gathered.refinements.push_back(core::refine(model.hierarchy(), model.meshes(), model.summary().lattice,
                                                model.summary().attributes, state.view, options, state.held,
                                                seen));
    if (const auto& cut = gathered.refinements.back().cut) cuts.push_back(cut);
  }
  if (cuts.size() < views_.size()) return gathered;
  gathered.all = cuts.size() == 1 ? gathered.refinements.front().cut : gatherMeshes(cuts);
  return gathered;
}

RefineOptions ViewGroup::optionsAt(Giving giving) const {
  RefineOptions options = options_;
  options.threshold_px *= std::exp2(static_cast<float>(coarsening_) / kStepsOfTwo);
  if (giving >= Giving::kFallbacks) options.fallback_budget_bytes = 0;
  options.finer_stand_ins = giving < Giving::kFinerStandIns;
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

/// Whether there is room for all that the views want.
bool ViewGroup::fits(const Wanted& wanted, bool to_spare) const noexcept {
  return !wanted.limited && hasRoom(wanted.bytes, options_.cut_budget_bytes, to_spare) &&
         hasRoom(wanted.drawn_bytes, options_.drawn_budget_bytes, to_spare);
}

/// Refines all views alike: down to the threshold, or to the smallest error that there is room for. It
/// becomes finer again where there is room to spare, so that it does not waver.
ViewGroup::Gathered ViewGroup::refineWithin(const Model& model) {
  const auto refineNow = [&] {
    RefineOptions options = optionsAt(Giving::kNothing);
    options.shares_memory = areHeldToOneError();
    return refineWith(model, options);
  };
  if (!areHeldToOneError()) coarsening_ = 0;
  Gathered gathered = refineNow();
  Wanted wanted = wantedBy(gathered);
  while (areHeldToOneError() && !fits(wanted, false) && coarsening_ < kMostCoarsening) {
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
  // Twice the error is a quarter of the triangles, and there are no more than those of the file.
  const uint64_t triangles = model.summary().triangles;
  const double most_bytes =
      std::max(static_cast<double>(wanted.bytes),
               static_cast<double>(meshBytes(triangles / 2, triangles, model.summary().attributes)));
  const double estimate = static_cast<double>(wanted.bytes) * std::exp2(2.0 * coarsening_ / kStepsOfTwo);
  wanted_bytes_ = static_cast<uint64_t>(std::min(estimate, most_bytes));
  return gathered;
}

/// Marks what the refinements use, and forgets pages that they do not, where memory is short.
/// @return whether there is room for it, here and where it is drawn, and with `to_spare` a part more.
bool ViewGroup::keep(Model& model, const Gathered& gathered, bool to_spare) const {
  std::vector<NodeKey> pages;
  std::vector<MeshKey> in_use, ancestors;
  for (const Refinement& refinement : gathered.refinements) {
    pages.insert(pages.end(), refinement.pages.begin(), refinement.pages.end());
    in_use.insert(in_use.end(), refinement.in_use.begin(), refinement.in_use.end());
    ancestors.insert(ancestors.end(), refinement.ancestors.begin(), refinement.ancestors.end());
  }
  model.hierarchy().use(pages, model.hierarchyBudgetBytes());
  const uint64_t used_bytes = model.meshes().use(in_use, ancestors);
  return hasRoom(used_bytes, model.meshes().budgetBytes(), to_spare) &&
         model.hierarchy().bytes() <= model.hierarchyBudgetBytes() &&
         (!gathered.all || hasRoom(gathered.all->drawn_bytes, drawn_budget_bytes_, to_spare));
}

/// Gives up what stands by, unseen, then what is finer than wanted, until there is room for the rest. It
/// comes back where there is room to spare or nothing more to come, so that not every arrival changes all of
/// it.
void ViewGroup::fit(Model& model, Gathered& gathered) {
  const Giving before = giving_;
  giving_ = Giving::kNothing;
  while (!keep(model, gathered, giving_ < before) && giving_ != Giving::kFinerStandIns) {
    giving_ = giving_ == Giving::kNothing ? Giving::kFallbacks : Giving::kFinerStandIns;
    gathered = refineWith(model, optionsAt(giving_));
  }
  const auto isSettled = [](const Refinement& refinement) { return refinement.settled; };
  if (std::ranges::all_of(gathered.refinements, isSettled)) giving_ = Giving::kNothing;
}

bool ViewGroup::refine(Model& model) {
  if (views_.empty() || !model.hierarchy().root()) return false;
  if (!views_changed_ && model_version_ == model.version()) return false;
  views_changed_ = false;
  model_version_ = model.version();
  // Half for the wanted cuts, half for those still shown, so that neither wait for the other.
  options_.hierarchy_budget_bytes = model.hierarchyBudgetBytes();
  options_.cut_budget_bytes = model.meshes().budgetBytes() / 2;
  options_.fallback_budget_bytes = model.meshes().budgetBytes() / kFallbackShare;
  Gathered gathered = refineWithin(model);
  // What hides a model in a scene is mostly not the model itself.
  if (views_.size() == 1 && gathered.all && lookAtWhatIsSeen(views_.front(), *gathered.all, model.summary()))
    gathered = refineWith(model, optionsAt(Giving::kNothing));
  fit(model, gathered);
  model.meshes().trim();
  publish(model, gathered);
  return true;
}

/// Takes over what a refinement has given.
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
  if (gathered.all) {
    cut_build_ = model.build();
    for (const Refinement& refinement : gathered.refinements) sign(*refinement.cut);
    sign(*gathered.all);
    if (model.textures()) dress(*gathered.all, gathered.refinements, model);
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

/// Says of what build a cut is, and against which threshold it has converged.
void ViewGroup::sign(Cut& cut) const {
  cut.build = cut_build_;
  cut.threshold_px = options_.threshold_px;
  cut.converged = cut.converged && coarsening_ == 0;
}

/// Says which tiles the cuts need, and gives them those that are there.
void ViewGroup::dress(Cut& all, std::span<const Refinement> refinements, Model& model) {
  TextureStream& textures = *model.textures();
  const double step = model.summary().lattice.step;
  const std::shared_ptr<const TextureSet>& set = textures.set();
  std::vector<TexturedPart> parts;
  for (size_t place = 0; set && place < refinements.size(); ++place) {
    const Cut& cut = *refinements[place].cut;
    for (size_t number = 0; number < partCount(cut); ++number) {
      const CutPart& part = partOf(cut, number);
      const MeshKey key{part.node, part.lod};
      if (model.meshes().footprint(key) == nullptr)  // decoded before the set was there
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
