#pragma once

#include "client/render/culling/farthest_squares.h"
#include "client/render/culling/occluders.h"
#include "client/render/framebuffer.h"
#include "client/render/gl_names.h"

namespace lode::render {

/// Reads back how deep a picture is. Made, used and destroyed on the thread of its context.
class DepthReader {
 public:
  /// Waits until all that was drawn is there. Leaves behind: as FarthestSquares.
  FarthestDepths read(const Framebuffer& picture);

 private:
  FarthestSquares squares_;
  GlRenderbuffer texels_;
  GlFramebuffer framebuffer_;
  uint32_t columns_ = 0, rows_ = 0;
};

}  // namespace lode::render
