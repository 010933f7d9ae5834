#pragma once

#include <cstdint>

#include "client/render/framebuffer.h"
#include "client/render/gl_names.h"

namespace lode::render {

/// Draws of a picture's depth what is farthest in each square of FarthestDepths::kSquarePx, over all samples.
/// Made, used and destroyed on the thread of its context.
class FarthestSquares {
 public:
  /// @throws Error kInternal if the driver rejects a shader.
  FarthestSquares();

  /// Into the lower left corner of a framebuffer of one float, a pixel for each square. Leaves behind: bound
  /// framebuffer, program, vertex array, viewport, no depth test.
  void draw(const Framebuffer& picture, GLuint framebuffer);

 private:
  GlProgram plain_program_, sampled_program_;
  GlVertexArray empty_array_;
};

/// Squares along a side of a picture of so many pixels.
uint32_t squareCount(uint32_t side_px) noexcept;

}  // namespace lode::render
