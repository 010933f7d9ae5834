#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "client/core/view/view.h"

namespace lode::app {

/// Shares one budget of memory among the models of a scene, so that all can be shown with the same error: as
/// memory goes with what a model needs for it, in proportion to that. Equal parts until one model is short.
/// Pure.
class SceneMemory {
 public:
  SceneMemory(uint64_t budget_bytes, size_t models);

  struct Need {
    uint64_t bytes = 0;     ///< for the error that is asked for, in any measure that is the same for all
    bool is_short = false;  ///< its part does not give it that
  };
  /// What is looked at, each frame. For one picture parts change a few times only, so that they come to rest.
  void setView(const core::View& view, float threshold_px);
  /// There is more in the same view: parts may change again.
  void allowChanges() noexcept { changes_ = 0; }
  /// @param needs  by model. @return whether parts have changed.
  bool share(std::span<const Need> needs);
  /// By model; together no more than the budget.
  const std::vector<uint64_t>& parts() const noexcept { return parts_; }

 private:
  uint64_t budget_bytes_;
  std::vector<uint64_t> parts_;
  core::View view_;
  float threshold_px_ = 0;
  int changes_ = 0;  ///< for this picture
};

struct GpuShare {
  uint64_t part_bytes = 0;  ///< what the model's part of the scene's memory allows it there
  uint64_t held_bytes = 0;
};
/// What each model may have on the GPU: what the others leave of the budget, as what they have there goes by
/// what they may have drawn. At least its own part: where all hold more than the budget, which has become
/// smaller, a model frees that only for a cut that it may have. Pure.
std::vector<uint64_t> gpuBudgets(uint64_t budget_bytes, std::span<const GpuShare> models);

}  // namespace lode::app
