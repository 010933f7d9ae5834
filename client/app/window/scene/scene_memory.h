#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "client/core/view/view.h"

namespace lode::app {

/// Divides the memory budget among the models of a scene so that all models reach the same error. All parts
/// are equal until a model is short of memory. Then each part is proportional to the memory that the model
/// needs for the requested error. Pure.
class SceneMemory {
 public:
  SceneMemory(uint64_t budget_bytes, size_t models);

  struct Need {
    uint64_t bytes = 0;     ///< memory that the requested error needs, in any unit that all models share
    bool is_short = false;  ///< the model's part is too small for these bytes
  };
  /// Sets the view; call setView() in each frame. While the view stays the same, parts change only a few
  /// times, so that the picture settles.
  void setView(const core::View& view, float threshold_px);
  /// Lets parts change again in the same view, because a model was added.
  void allowChanges() noexcept { changes_ = 0; }
  /// Divides the budget again if a model is short. @param needs  by model. @return true if parts have
  /// changed.
  bool share(std::span<const Need> needs);
  /// Returns the bytes of each model. Their sum is at most the budget.
  const std::vector<uint64_t>& parts() const noexcept { return parts_; }

 private:
  uint64_t budget_bytes_;
  std::vector<uint64_t> parts_;
  core::View view_;
  float threshold_px_ = 0;
  int changes_ = 0;  ///< number of changes in this view
};

/// GPU memory of a model.
struct GpuShare {
  uint64_t part_bytes = 0;  ///< GPU bytes in the model's part of the memory budget
  uint64_t held_bytes = 0;  ///< GPU bytes that the model uses
};
/// Returns the GPU budget of each model: the bytes of the common budget that the other models do not use, but
/// at least the model's own part. If the common budget shrinks below the bytes in use, the model needs its
/// part to upload a smaller cut, which then frees memory. Pure.
std::vector<uint64_t> gpuBudgets(uint64_t budget_bytes, std::span<const GpuShare> models);

}  // namespace lode::app
