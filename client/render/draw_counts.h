#pragma once

#include <cstdint>

#include "client/render/shown_thresholds.h"

namespace lode::render {

/// What a picture was made of.
struct DrawCounts {
  /// Drawn, after culling; where the GPU finds what is hidden, of a frame some frames ago.
  uint64_t triangles = 0;
  uint32_t nodes = 0;
  uint32_t calls = 0;
  float error_px = 0;  ///< largest in the picture, from where the cut was made for
  ShownThresholds shown;

  DrawCounts& operator+=(const DrawCounts& more) noexcept;
};

}  // namespace lode::render
