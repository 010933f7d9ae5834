#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "client/core/view/view.h"

namespace lode::app {

/// Divides the memory budget among the models of a scene so that all reach the same error: in proportion to
/// the memory that each needs for the requested error. Equal parts until one model is short. Pure.
class SceneMemory {
 public:
  SceneMemory(uint64_t budget_bytes, size_t models);

  struct Need {
    uint64_t bytes = 0;     ///< for the requested error, in any unit common to all models
    bool is_short = false;  ///< its part does not hold that
  };
  /// Call each frame. While the view stays, parts change only a few times, so that the picture settles.
  void setView(const core::View& view, float threshold_px);
  /// Lets parts change again in the same view, because a model was added.
  void allowChanges() noexcept { changes_ = 0; }
  /// @param needs  by model. @return true if parts have changed.
  bool share(std::span<const Need> needs);
  /// Bytes by model; together at most the budget.
  const std::vector<uint64_t>& parts() const noexcept { return parts_; }

 private:
  uint64_t budget_bytes_;
  std::vector<uint64_t> parts_;
  core::View view_;
  float threshold_px_ = 0;
  int changes_ = 0;  ///< in this view
};

struct GpuShare {
  uint64_t part_bytes = 0;  ///< GPU bytes in the model's part of the memory budget
  uint64_t held_bytes = 0;  ///< GPU bytes that the model uses
};
/// Returns the GPU budget of each model: the part of the common budget that the others do not use, at least
/// its own part. When the common budget shrinks below the bytes in use, a model can free memory only by
/// uploading a smaller cut, which needs its own part. Pure.
std::vector<uint64_t> gpuBudgets(uint64_t budget_bytes, std::span<const GpuShare> models);

}  // namespace lode::app
