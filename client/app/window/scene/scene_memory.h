#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "client/core/view/view.h"

namespace lode::app {

/// Divides the memory budget among the models of a scene so that all models reach the same error. All parts
/// are equal until a model is short of memory. From then on, 1/8 of the budget is divided equally, and the
/// rest in proportion to the memory that each model needs for the requested error. Pure.
class SceneMemory {
 public:
  SceneMemory(uint64_t budget_bytes, size_t models);

  struct Need {
    uint64_t bytes = 0;     ///< memory needed for the requested error, in a unit common to all models
    bool is_short = false;  ///< the model's part is too small for this need
  };
  /// Sets the view; call this function in each frame. While the view stays the same, parts change only a few
  /// times, so that the picture settles.
  void setView(const core::View& view, float threshold_px);
  /// Lets parts change again in the same view, because models were added, hidden or shown.
  void allowChanges() noexcept { changes_ = 0; }
  /// Divides the budget anew if a model is short of memory. @param needs  need of each model. @return true if
  /// parts have changed.
  bool share(std::span<const Need> needs);
  /// Returns the part of each model in bytes. The sum of the parts is at most the budget.
  const std::vector<uint64_t>& parts() const noexcept { return parts_; }

 private:
  uint64_t budget_bytes_;
  std::vector<uint64_t> parts_;
  core::View view_;
  float threshold_px_ = 0;
  int changes_ = 0;  ///< number of times that parts have changed in this view
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
