#pragma once

#include <cstdint>

#include "client/render/culling/farthest_squares.h"
#include "client/render/framebuffer.h"
#include "client/render/gl_names.h"

namespace lode::render {

/// How deep a picture is, kept on the GPU: level 0 has FarthestDepths' squares, each further one the farthest
/// of 2 × 2 of the one before, so that any box is held against 16 texels at most. Made, used and destroyed on
/// the thread of its context. Source: Greene, Kass and Miller, Hierarchical Z-buffer Visibility, 1993.
class DepthPyramid {
 public:
  /// @throws Error kInternal if the driver rejects a shader.
  DepthPyramid();

  /// Of all that was drawn; waits for nothing. Leaves behind: as FarthestSquares.
  void build(const Framebuffer& picture);

  /// Depths are reversed; beyond the picture they are 1, which hides all.
  GLuint texture() const noexcept { return texture_.get(); }
  /// Of the picture; 0: none was built yet.
  uint32_t widthPx() const noexcept { return width_px_; }
  uint32_t heightPx() const noexcept { return height_px_; }

 private:
  void makeTexture(uint32_t columns, uint32_t rows);

  FarthestSquares squares_;
  GlProgram coarser_program_;
  GlTexture texture_;
  GlFramebuffer framebuffer_;
  GLsizei texture_width_ = 0, texture_height_ = 0, levels_ = 0;
  uint32_t width_px_ = 0, height_px_ = 0;
};

}  // namespace lode::render
