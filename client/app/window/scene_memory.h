#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "client/core/view.h"

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
  void look(const core::View& view, float threshold_px);
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

}  // namespace lode::app
