#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "client/core/lod/cut.h"
#include "client/core/lod/refiner.h"
#include "client/core/lod/request.h"
#include "client/core/lod/seen_places.h"
#include "client/core/model.h"
#include "client/core/view/view.h"

namespace lode::core {

/// The views of a model that are drawn at one time, one for each place where it stands: from the views and
/// what is resident, a cut for each and the requests the rest. Meshes and budgets are shared by all views.
/// Where a budget does not allow what several views want, all are held to the same larger error. Not thread
/// safe; the cuts it gives are.
class ViewGroup {
 public:
  /// @param options  what of them stays: the hysteresis and the budgets of triangles and of drawn bytes; the
  ///                 latter is here for the cut and its fallbacks together.
  explicit ViewGroup(const RefineOptions& options = {});

  /// Of drawn bytes, as in the options.
  void setDrawnBudget(uint64_t bytes) noexcept;
  /// @param views  in the model frame, of pictures of one size.
  void setViews(std::span<const View> views, float threshold_px);
  void setView(const View& view, float threshold_px) { setViews({&view, 1}, threshold_px); }
  /// Another build has taken the model's place: the last cut stays until the new one has one.
  void forgetModel() noexcept;

  /// Refines if a view or the model has changed. @return whether it did.
  bool refine(Model& model);

  /// The last cuts; null until the root's coarsest LOD is there and a view is set.
  const std::shared_ptr<const ViewCuts>& viewCuts() const noexcept { return view_cuts_; }
  /// Their meshes: of one view, its cut. Null as viewCuts().
  const std::shared_ptr<const Cut>& cut() const noexcept;
  /// The build that they are of: see Model::build().
  uint64_t cutBuild() const noexcept { return cut_build_; }
  /// What the last refinement asks for, best first.
  const std::vector<Request>& requests() const noexcept { return requests_; }
  /// Owners of the pages that it goes through.
  const std::vector<NodeKey>& pages() const noexcept { return pages_; }
  const RefineOptions& options() const noexcept { return options_; }
  /// How many there are; none before the first.
  size_t viewCount() const noexcept { return views_.size(); }
  /// @param number  below viewCount().
  const View& view(size_t number) const noexcept { return views_[number].view; }
  /// A budget keeps the last cuts from converging.
  bool limited() const noexcept { return limited_; }
  /// What the views want of the memory for meshes, for the error that is asked for; where a budget does not
  /// allow that, an estimate. 0 unless the options hold views to one error or there are several.
  uint64_t wantedBytes() const noexcept { return wanted_bytes_; }
  /// The last cuts are all that the views and the budgets will ever give.
  bool settled() const noexcept { return settled_; }

 private:
  /// What is given up where there is no room for all that could be shown, each with what comes before.
  enum class Giving { kNothing, kFallbacks, kFinerStandIns };

  /// A view, and what is kept of it from one refinement to the next.
  struct ViewState {
    View view;
    std::vector<HeldNode> held;
    std::optional<SeenPlaces> seen;  // by the view, as far as known, and
    uint64_t seen_triangles = 0;     // those of the cut that told
  };

  /// What all views have together.
  struct Gathered {
    std::vector<Refinement> refinements;  // by view
    std::shared_ptr<Cut> all;             // null while a view has none
  };

  static bool lookAtWhatIsSeen(ViewState& state, const Cut& cut, const ModelSummary& model);
  Gathered refineWith(const Model& model, const RefineOptions& options) const;
  RefineOptions optionsAt(Giving giving) const;
  /// Of the wanted cuts together: decoded, and where they are drawn.
  struct Wanted {
    uint64_t bytes = 0, drawn_bytes = 0;
    bool limited = false;  // a budget has stopped one
  };

  bool areHeldToOneError() const noexcept { return views_.size() > 1 || options_.shares_memory; }
  static Wanted wantedBy(const Gathered& gathered);
  bool fits(const Wanted& wanted, bool to_spare) const noexcept;
  Gathered refineWithin(const Model& model);
  bool keep(Model& model, const Gathered& gathered, bool to_spare) const;
  void fit(Model& model, Gathered& gathered);
  void publish(Model& model, Gathered& gathered);
  void sign(Cut& cut) const;
  void dress(Cut& all, std::span<const Refinement> refinements, Model& model);

  RefineOptions options_;
  uint64_t drawn_budget_bytes_ = 0;  // of the cuts and their fallbacks
  std::vector<ViewState> views_;
  uint64_t model_version_ = 0;  // that the last refinement saw
  bool views_changed_ = false;
  std::shared_ptr<const ViewCuts> view_cuts_;
  uint64_t cut_build_ = 0;
  std::vector<Request> requests_;
  std::vector<NodeKey> pages_;
  Giving giving_ = Giving::kNothing;  // by the last refinement,
  uint64_t wanted_bytes_ = 0;
  int coarsening_ = 0;  // and steps of the threshold that it was raised by
  bool limited_ = false, settled_ = false;
};

}  // namespace lode::core
