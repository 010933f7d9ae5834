#pragma once

#include <cstdint>
#include <limits>
#include <vector>

namespace lode::core {

constexpr uint64_t kPartBytes = 256;     ///< memory per part of a cut, in addition to the part's mesh
constexpr double kMarginWidening = 1.2;  ///< width of the picture with its margin, relative to the picture
constexpr float kHysteresisFactor = 0.841f;  ///< 2^-1/4, for interactive viewers

/// State of one node in the previous refinement, for hysteresis. In a list of these states, the root comes
/// first, and the children of a node are consecutive.
struct HeldNode {
  uint32_t first_child = 0;  ///< index of the first child; 0: the node is not expanded
  uint32_t lod = 0;
};

struct RefineOptions {
  float threshold_px = 1;  ///< largest projected error allowed; ViewGroup::setViews() sets it
  uint64_t triangle_budget = std::numeric_limits<uint64_t>::max();
  /// Budget for the GPU memory of the wanted cut: see drawnBytes(). Stand-ins, shown until the wanted cut is
  /// resident, may take more memory: see Cut::drawn_bytes.
  uint64_t drawn_budget_bytes = std::numeric_limits<uint64_t>::max();
  /// Hysteresis: a node that was finer in the previous refinement stays finer until its error falls below
  /// this fraction of the threshold, which prevents LOD flicker. 1 disables hysteresis, so that the cut
  /// depends on the view alone.
  float hysteresis_factor = 1;
  /// True if several models or views share the budgets. Refinement then fills Refinement::wanted_meshes, and
  /// ViewGroup raises the threshold if a budget is too small, even for a single view. If false, refinement of
  /// a single view stops at the budget.
  bool shares_memory = false;

  // ViewGroup sets the options below.
  /// Budget for the memory of the wanted cut and its decoded meshes.
  uint64_t cut_budget_bytes = std::numeric_limits<uint64_t>::max();
  /// Budget for the memory of the hierarchy pages that the wanted cut needs; refinement stops at the budget.
  uint64_t hierarchy_budget_bytes = std::numeric_limits<uint64_t>::max();
  bool finer_stand_ins = true;  ///< if false, a coarser mesh stands in for a missing mesh, never a finer one
  /// Budget for the memory of fallbacks. If a fallback does not fit, the nearest ancestor that fits replaces
  /// it. The last resort is the root's coarsest resident LOD, to which no budget applies.
  uint64_t fallback_budget_bytes = std::numeric_limits<uint64_t>::max();
  /// Budget for the GPU memory of fallbacks.
  uint64_t fallback_drawn_budget_bytes = std::numeric_limits<uint64_t>::max();
};

}  // namespace lode::core
