#include "client/core/instance.h"

#include <algorithm>
#include <utility>

#include "client/core/shown_parts.h"

namespace lode::core {
namespace {

constexpr uint64_t kFinerRatio = 2;  // of a cut's triangles, from which on it is worth to look anew
// One in so many bytes of the meshes, and of what may be drawn, is for fallbacks.
constexpr uint64_t kFallbackShare = 8;

}  // namespace

Instance::Instance(const RefineOptions& options)
    : options_(options), drawn_budget_bytes_(options.drawn_budget_bytes) {
  options_.drawn_budget_bytes -= options.drawn_budget_bytes / kFallbackShare;
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

/// Marks what a refinement uses, and forgets pages that it does not, where memory is short.
/// @return false if it uses more than there is room for, here or where it is drawn.
bool Instance::keep(Model& model, const Refinement& refinement) const {
  model.hierarchy().use(refinement.pages, model.hierarchyBudgetBytes());
  return model.meshes().use(refinement.in_use, refinement.ancestors) <= model.meshes().budgetBytes() &&
         model.hierarchy().bytes() <= model.hierarchyBudgetBytes() &&
         (!refinement.cut || refinement.cut->drawn_bytes <= drawn_budget_bytes_);
}

/// Gives up what stands by, unseen, then what is finer than wanted, until there is room for the rest.
void Instance::fit(Model& model, Refinement& refinement) const {
  if (keep(model, refinement)) return;
  RefineOptions options = options_;
  options.fallback_budget_bytes = 0;
  refinement = refineWith(model, options);
  if (keep(model, refinement)) return;
  options.finer_stand_ins = false;
  refinement = refineWith(model, options);
  keep(model, refinement);
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
