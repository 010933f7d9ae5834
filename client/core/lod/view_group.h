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

/// The views of one model that are drawn together, one per instance of the model. Refines a cut for each view
/// from the resident meshes and collects the requests for the missing meshes. All views share meshes and
/// budgets; if a budget is too small for several views, one larger threshold applies to all views. Not thread
/// safe, but any thread may read the published cuts.
class ViewGroup {
 public:
  /// @param options  see RefineOptions; drawn_budget_bytes applies to the cuts and their fallbacks together.
  explicit ViewGroup(const RefineOptions& options = {});

  /// Sets a new value for RefineOptions::drawn_budget_bytes.
  void setDrawnBudget(uint64_t bytes) noexcept;
  /// @param views  views in the model frame, all with the same picture size.
  void setViews(std::span<const View> views, float threshold_px);
  void setView(const View& view, float threshold_px) { setViews({&view, 1}, threshold_px); }
  /// Notes that another build has replaced the model. The last cuts stay until cuts of the new build are as
  /// sharp or final, or the views change.
  void forgetModel() noexcept;

  /// Refines the cuts if a view or the model has changed. @return true if the cuts were refined.
  bool refine(Model& model);

  /// Returns the last published cuts; null until the root's coarsest LOD is resident and a view is set.
  const std::shared_ptr<const ViewCuts>& viewCuts() const noexcept { return view_cuts_; }
  /// Returns ViewCuts::all of the last cuts; null if viewCuts() is null.
  const std::shared_ptr<const Cut>& cut() const noexcept;
  /// Returns Model::build() of the last cuts.
  uint64_t cutBuild() const noexcept { return cut_build_; }
  /// Returns the requests of the last refinement, best first.
  const std::vector<Request>& requests() const noexcept { return requests_; }
  /// Returns the owners of the pages that the cuts need.
  const std::vector<NodeKey>& pages() const noexcept { return pages_; }
  const RefineOptions& options() const noexcept { return options_; }
  /// Returns the number of views; 0 before setViews().
  size_t viewCount() const noexcept { return views_.size(); }
  /// @param number  number less than viewCount().
  const View& view(size_t number) const noexcept { return views_[number].view; }
  /// Returns true if a budget prevents the last cuts from converging.
  bool limited() const noexcept { return limited_; }
  /// Returns the memory of the meshes that the views need at the requested threshold; an estimate if a budget
  /// is too small for these meshes. Returns 0 for a single view, unless RefineOptions::shares_memory is set.
  uint64_t wantedBytes() const noexcept { return wanted_bytes_; }
  /// Returns true if the last cuts are final for these views and budgets.
  bool settled() const noexcept { return settled_; }

 private:
  /// Steps that save memory when it is short; each step includes the earlier ones.
  enum class Degradation { kNone, kNoFallbacks, kNoFinerStandIns };

  /// A view and its state between refinements.
  struct ViewState {
    View view;
    std::vector<HeldNode> held;
    std::optional<SeenPlaces> seen;  // nothing if occlusion is unknown
    uint64_t seen_triangles = 0;     // number of triangles of the cut from which `seen` was computed
  };

  /// Results of one refinement of all views.
  struct Gathered {
    std::vector<Refinement> refinements;  // one refinement per view
    std::shared_ptr<Cut> all;             // union of the cuts; null while a view has no cut
  };

  static bool updateOcclusion(ViewState& state, const Cut& cut, const ModelSummary& model);
  Gathered refineWith(const Model& model, const RefineOptions& options) const;
  RefineOptions optionsAt(Degradation degradation) const;
  /// Memory of all wanted cuts together, in main memory and on the GPU.
  struct Wanted {
    uint64_t bytes = 0, drawn_bytes = 0;
    bool limited = false;  // a budget stopped the refinement of at least one view
  };

  bool usesOneThreshold() const noexcept { return views_.size() > 1 || options_.shares_memory; }
  static Wanted wantedBy(const Gathered& gathered);
  bool fits(const Wanted& wanted, bool with_reserve) const noexcept;
  Gathered refineWithin(const Model& model);
  bool keep(Model& model, const Gathered& gathered, bool with_reserve) const;
  void fit(Model& model, Gathered& gathered);
  bool keepsReplaced(const Model& model, const Cut& all) const;
  void publish(Model& model, Gathered& gathered);
  void label(Cut& cut) const;
  void addTextures(Cut& all, std::span<const Refinement> refinements, Model& model);

  RefineOptions options_;
  uint64_t drawn_budget_bytes_ = 0;  // budget for the cuts and their fallbacks together
  std::vector<ViewState> views_;
  uint64_t model_version_ = 0;  // Model::version() at the last refinement
  bool views_changed_ = false;
  std::shared_ptr<const ViewCuts> view_cuts_;
  uint64_t cut_build_ = 0;
  std::vector<Request> requests_;
  std::vector<NodeKey> pages_;
  Degradation degradation_ = Degradation::kNone;  // degradation that the last refinement used
  uint64_t wanted_bytes_ = 0;
  int coarsening_ = 0;  // number of steps by which the threshold is raised
  bool limited_ = false, settled_ = false;
};

}  // namespace lode::core
