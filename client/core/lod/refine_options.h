#pragma once

#include <cstdint>
#include <limits>
#include <vector>

namespace lode::core {

constexpr uint64_t kPartBytes = 256;         ///< memory of a part of a cut in addition to its mesh
constexpr double kMarginWidening = 1.2;      ///< width of the view with its margin, relative to the picture
constexpr float kHysteresisFactor = 0.841f;  ///< 2^-1/4: suits an interactive viewer

/// State of one node in the previous refinement, for hysteresis. The root comes first; the children of a node
/// are consecutive.
struct HeldNode {
  uint32_t first_child = 0;  ///< index of the first child; 0: not expanded
  uint32_t lod = 0;
};

struct RefineOptions {
  float threshold_px = 1;  ///< largest projected error allowed; ViewGroup::setViews() sets it
  uint64_t triangle_budget = std::numeric_limits<uint64_t>::max();
  /// GPU memory of the wanted cut: see drawnBytes(). Stand-ins shown until it is resident may take more: see
  /// Cut::drawn_bytes.
  uint64_t drawn_budget_bytes = std::numeric_limits<uint64_t>::max();
  /// Hysteresis: a node that was finer in the previous refinement stays finer until its error falls below
  /// this fraction of the threshold, which prevents LOD flicker. 1: none, and the cut depends on the view
  /// alone.
  float hysteresis_factor = 1;
  /// Several models or views share the budgets: lists Refinement::wanted_meshes, and where a budget is short
  /// ViewGroup raises the threshold of a single view too, instead of stopping at the budget.
  bool shares_memory = false;

  // ViewGroup sets the options below.
  uint64_t cut_budget_bytes =
      std::numeric_limits<uint64_t>::max();  ///< memory of the wanted cut with its decoded meshes
  /// Memory of the hierarchy pages that the wanted cut needs; refinement stops there.
  uint64_t hierarchy_budget_bytes = std::numeric_limits<uint64_t>::max();
  bool finer_stand_ins = true;  ///< false: replaces meshes finer than wanted by coarser ancestors at once
  /// Memory of fallbacks. Above it an ancestor higher up serves as fallback, at last the root's coarsest LOD,
  /// which counts against no budget.
  uint64_t fallback_budget_bytes = std::numeric_limits<uint64_t>::max();
  uint64_t fallback_drawn_budget_bytes = std::numeric_limits<uint64_t>::max();  ///< GPU memory of fallbacks
};

}  // namespace lode::core
