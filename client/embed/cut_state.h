#pragma once

#include "client/core/lod/cut.h"

namespace lode::embed {

/// What is seen is off by no more than that: a leaf at its original triangles may be, where core::Cut has
/// converged.
inline bool isWithin(const core::Cut& cut, float threshold_px) noexcept {
  return cut.converged && cut.max_error_px <= threshold_px;
}

/// It is not within its threshold, and nothing finer is to be had.
inline bool isFinest(const core::Cut& cut) noexcept {
  return cut.converged && !isWithin(cut, cut.threshold_px);
}

}  // namespace lode::embed
