#pragma once

#include "client/render/framebuffer.h"
#include "client/render/gl_names.h"
#include "client/render/occluders.h"

namespace lode::render {

/// True where pictures are drawn by the processor: there, what is drawn can be read back at no cost but the
/// wait for it. Of the current context.
bool drawsInSoftware();

/// Reads back how deep a picture is. Made, used and destroyed on the thread of its context.
class DepthReader {
 public:
  /// @throws Error kInternal if the driver rejects a shader.
  DepthReader();

  /// Waits until all that was drawn is there. Leaves behind: bound framebuffers, program, vertex array,
  /// viewport, no depth test.
  FarthestDepths read(const Framebuffer& picture);

 private:
  GlProgram plain_program_, sampled_program_;
  GlVertexArray empty_array_;
  GlRenderbuffer squares_;
  GlFramebuffer framebuffer_;
  uint32_t columns_ = 0, rows_ = 0;
};

}  // namespace lode::render
