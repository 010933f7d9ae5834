#pragma once

#include <cstdint>
#include <limits>
#include <vector>

namespace lode::core {

constexpr uint64_t kPartBytes = 256;  ///< that a part of a cut takes beside its mesh, and where it has none
constexpr double kMarginWidening = 1.2;  ///< of the picture: what a camera that turns a little sees next
constexpr float kHysteresisFactor =
    0.841f;  ///< 2^-1/4: a part that a viewer has refined stays so above this threshold

/// What a refinement has made of a node, for the next one: children follow one another, the root is the
/// first.
struct HeldNode {
  uint32_t first_child = 0;  ///< 0: it was not expanded
  uint32_t lod = 0;
};

struct RefineOptions {
  float threshold_px = 1;
  uint64_t triangle_budget = std::numeric_limits<uint64_t>::max();
  /// Of the wanted cut's meshes where they are drawn: see drawnBytes(). What is shown until it is there may
  /// take more: see Cut::drawn_bytes.
  uint64_t drawn_budget_bytes = std::numeric_limits<uint64_t>::max();
  uint64_t cut_budget_bytes =
      std::numeric_limits<uint64_t>::max();  ///< of the wanted cut and its decoded meshes
  /// Of the pages that the wanted cut needs: nothing is refined beyond it.
  uint64_t hierarchy_budget_bytes = std::numeric_limits<uint64_t>::max();
  bool finer_stand_ins = true;  ///< false: what is finer than wanted gives way to coarser ancestors at once
  /// Of fallbacks; beyond it an ancestor above stands by, at last the root's coarsest LOD, which counts
  /// nowhere.
  uint64_t fallback_budget_bytes = std::numeric_limits<uint64_t>::max();
  uint64_t fallback_drawn_budget_bytes =
      std::numeric_limits<uint64_t>::max();  ///< the same where it is drawn
  /// Hysteresis: what was finer in the last refinement stays so until it is this much below the threshold, so
  /// that nothing flickers. 1: none, and the cut depends on the view alone.
  float hysteresis_factor = 1;
  /// Refinement::wanted_meshes is to be made; a ViewGroup holds a single view, too, to a larger error where a
  /// budget is short.
  bool shares_memory = false;
};

}  // namespace lode::core
