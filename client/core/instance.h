#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "client/core/cut.h"
#include "client/core/model.h"
#include "client/core/refiner.h"
#include "client/core/seen_places.h"
#include "client/core/view.h"
#include "client/core/wish.h"

namespace lode::core {

/// A view of a model: from the view and what is resident, the cut to draw and the wishes for the rest.
/// Not thread safe; the cuts it gives are.
class Instance {
 public:
  /// @param options  what of them stays: the hysteresis and the budgets of triangles and of drawn bytes; the
  ///                 latter is here for the cut and its fallbacks together.
  explicit Instance(const RefineOptions& options = {});

  /// @param view  in the model frame.
  void setView(const View& view, float threshold_px);
  /// Another build has taken the model's place: the last cut stays until the new one has one.
  void forgetModel() noexcept {
    model_version_ = 0;
    settled_ = limited_ = false;
    giving_ = Giving::kNothing;
    held_.clear();
    wishes_.clear();
    pages_.clear();
    seen_.reset();
    seen_triangles_ = 0;
  }

  /// Refines if the view or the model has changed. @return whether it did.
  bool refine(Model& model);

  /// The last cut; null until the root's coarsest rung is there and a view is set.
  const std::shared_ptr<const Cut>& cut() const noexcept { return cut_; }
  /// The build that it is of: see Model::build().
  uint64_t cutBuild() const noexcept { return cut_build_; }
  /// What the last refinement asks for, best first.
  const std::vector<Wish>& wishes() const noexcept { return wishes_; }
  /// Owners of the pages that it goes through.
  const std::vector<NodeKey>& pages() const noexcept { return pages_; }
  const RefineOptions& options() const noexcept { return options_; }
  /// Null before the first.
  const View* view() const noexcept { return view_ ? &*view_ : nullptr; }
  /// A budget keeps the last cut from converging.
  bool limited() const noexcept { return limited_; }
  /// The last cut is all that the view and the budgets will ever give.
  bool settled() const noexcept { return settled_; }

 private:
  /// What is given up where there is no room for all that could be shown, each with what comes before.
  enum class Giving { kNothing, kFallbacks, kFinerStandIns };

  bool lookAtWhatIsSeen(const Cut& cut, const ModelSummary& model);
  Refinement refineWith(const Model& model, const RefineOptions& options) const;
  RefineOptions optionsAt(Giving giving) const;
  bool keep(Model& model, const Refinement& refinement, bool to_spare) const;
  void fit(Model& model, Refinement& refinement);
  void dress(Cut& cut, Model& model);

  RefineOptions options_;
  uint64_t drawn_budget_bytes_;  // of the cut and its fallbacks
  std::optional<View> view_;
  uint64_t model_version_ = 0;  // that the last refinement saw
  bool view_changed_ = false;
  std::shared_ptr<const Cut> cut_;
  uint64_t cut_build_ = 0;
  std::vector<Wish> wishes_;
  std::vector<NodeKey> pages_;
  std::vector<HeldNode> held_;        // by the last refinement
  std::optional<SeenPlaces> seen_;    // by the view, as far as known, and
  uint64_t seen_triangles_ = 0;       // those of the cut that told
  Giving giving_ = Giving::kNothing;  // by the last refinement
  bool limited_ = false, settled_ = false;
};

}  // namespace lode::core
