#include "client/core/instance.h"

#include <algorithm>
#include <utility>

#include "client/core/shown_parts.h"

namespace lode::core {
namespace {

constexpr uint64_t kFinerRatio = 2;  // of a cut's triangles, from which on it is worth to look anew
// One in so many bytes of the meshes, and of what may be drawn, is for fallbacks.
constexpr uint64_t kFallbackShare = 8;
constexpr uint64_t kSpareShare = 4;  // one in so many bytes is free before what was given up comes back

}  // namespace

Instance::Instance(const RefineOptions& options)
    : options_(options), drawn_budget_bytes_(options.drawn_budget_bytes) {
  options_.fallback_drawn_budget_bytes = drawn_budget_bytes_ / kFallbackShare;
  options_.drawn_budget_bytes -= options_.fallback_drawn_budget_bytes;
}

void Instance::setView(const View& view, float threshold_px) {
  if (view_ == view && options_.threshold_px == threshold_px) return;
  view_ = view;
  options_.threshold_px = threshold_px;
  view_changed_ = true;
  seen_.reset();
  seen_triangles_ = 0;
}

/// Where something is missing: at once, and again whenever the cut has become finer.
/// @return whether more is known than before.
bool Instance::lookAtWhatIsSeen(const Cut& cut, const ModelSummary& model) {
  if (cut.converged || cut.triangles < kFinerRatio * seen_triangles_ ||
      cut.triangles > SeenPlaces::kMostTriangles)
    return false;
  seen_ = SeenPlaces::of(cut, model);
  seen_triangles_ = cut.triangles;
  return seen_.has_value();
}

Refinement Instance::refineWith(const Model& model, const RefineOptions& options) const {
  return core::refine(model.hierarchy(), model.meshes(), model.summary().lattice, model.summary().attributes,
                      *view_, options, held_, seen_ ? &*seen_ : nullptr);
}

RefineOptions Instance::optionsAt(Giving giving) const {
  RefineOptions options = options_;
  if (giving >= Giving::kFallbacks) options.fallback_budget_bytes = 0;
  options.finer_stand_ins = giving < Giving::kFinerStandIns;
  return options;
}

/// Marks what a refinement uses, and forgets pages that it does not, where memory is short.
/// @return whether there is room for it, here and where it is drawn, and with `to_spare` a part more.
bool Instance::keep(Model& model, const Refinement& refinement, bool to_spare) const {
  model.hierarchy().use(refinement.pages, model.hierarchyBudgetBytes());
  const auto has_room = [&](uint64_t bytes, uint64_t budget_bytes) {
    return bytes <= budget_bytes - (to_spare ? budget_bytes / kSpareShare : 0);
  };
  const uint64_t used_bytes = model.meshes().use(refinement.in_use, refinement.ancestors);
  return has_room(used_bytes, model.meshes().budgetBytes()) &&
         model.hierarchy().bytes() <= model.hierarchyBudgetBytes() &&
         (!refinement.cut || has_room(refinement.cut->drawn_bytes, drawn_budget_bytes_));
}

/// Gives up what stands by, unseen, then what is finer than wanted, until there is room for the rest. It
/// comes back where there is room to spare or nothing more to come, so that not every arrival changes all of
/// it.
void Instance::fit(Model& model, Refinement& refinement) {
  const Giving before = giving_;
  giving_ = Giving::kNothing;
  while (!keep(model, refinement, giving_ < before) && giving_ != Giving::kFinerStandIns) {
    giving_ = giving_ == Giving::kNothing ? Giving::kFallbacks : Giving::kFinerStandIns;
    refinement = refineWith(model, optionsAt(giving_));
  }
  if (refinement.settled) giving_ = Giving::kNothing;
}

bool Instance::refine(Model& model) {
  if (!view_ || !model.hierarchy().root()) return false;
  if (!view_changed_ && model_version_ == model.version()) return false;
  view_changed_ = false;
  model_version_ = model.version();
  // Half for the wanted cut, half for the one still shown, so that neither waits for the other.
  options_.hierarchy_budget_bytes = model.hierarchyBudgetBytes();
  options_.cut_budget_bytes = model.meshes().budgetBytes() / 2;
  options_.fallback_budget_bytes = model.meshes().budgetBytes() / kFallbackShare;
  Refinement refinement = refineWith(model, options_);
  if (refinement.cut && lookAtWhatIsSeen(*refinement.cut, model.summary()))
    refinement = refineWith(model, options_);
  fit(model, refinement);
  model.meshes().trim();
  held_ = std::move(refinement.held);
  settled_ = refinement.settled;
  limited_ = refinement.limited;
  if (refinement.cut) {
    cut_build_ = refinement.cut->build = model.build();
    if (model.textures()) dress(*refinement.cut, model);
    cut_ = std::move(refinement.cut);
  }
  wishes_ = std::move(refinement.wanted);
  pages_ = std::move(refinement.pages);
  if (!model.textures()) return true;
  const std::vector<Wish>& missing = model.textures()->missing();
  wishes_.insert(wishes_.end(), missing.begin(), missing.end());
  std::stable_sort(wishes_.begin(), wishes_.end(), [](const Wish& a, const Wish& b) {
    if (a.wish_class != b.wish_class) return a.wish_class < b.wish_class;
    return a.priority_px > b.priority_px;
  });
  return true;
}

/// Says which tiles the cut needs, and gives it those that are there.
void Instance::dress(Cut& cut, Model& model) {
  TextureStream& textures = *model.textures();
  const double step = model.summary().lattice.step;
  const std::shared_ptr<const TextureSet>& set = textures.set();
  std::vector<TexturedPart> parts;
  for (size_t number = 0; set && number < partCount(cut); ++number) {
    const CutPart& part = partOf(cut, number);
    const MeshKey key{part.node, part.rung};
    if (model.meshes().footprint(key) == nullptr)  // decoded before the set was there
      model.meshes().setFootprint(
          key, std::make_shared<const TextureFootprint>(makeFootprint(*part.mesh, *set, step)));
    const ModelBox box = toModelBox(model.hierarchy().find(part.node)->box, step);
    parts.push_back({model.meshes().footprint(key), distanceToBox(view_->eye_model, box), part.visible});
  }
  textures.refine(parts, *view_, options_.threshold_px);
  cut.textures = set;
  cut.tiles = textures.residentTiles();
  cut.blob_bytes += textures.blobBytesInUse();
  settled_ = settled_ && textures.complete();
  cut.converged = cut.converged && textures.complete();
}

}  // namespace lode::core
