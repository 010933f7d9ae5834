#pragma once

#include <cstdint>

#include "client/render/culling/occluders.h"
#include "client/render/gl/framebuffer.h"
#include "client/render/gl/gl_names.h"

namespace lode::render {

/// Reduces a picture's depth buffer to one value per square of FarthestDepths::kSquarePx pixels a side: the
/// farthest depth of all samples in the square. Create, use and destroy the object on the thread of its
/// OpenGL context.
class FarthestSquares {
 public:
  /// @throws Error kInternal if the driver rejects a shader.
  FarthestSquares();

  /// Draws one pixel per square into the lower left corner of a framebuffer that has one float channel.
  /// Changes the bound framebuffer, program, vertex array and viewport, and disables the depth test.
  void draw(const Framebuffer& picture, GLuint framebuffer);

 private:
  GlProgram plain_program_, sampled_program_;
  GlVertexArray empty_array_;
};

/// Returns the number of squares along a side of `side_px` pixels.
uint32_t squareCount(uint32_t side_px) noexcept;

/// Reads a picture's farthest depths back to the CPU. Create, use and destroy the object on the thread of its
/// OpenGL context.
class DepthReader {
 public:
  /// Blocks until the picture is drawn. Changes the same state as FarthestSquares::draw().
  FarthestDepths read(const Framebuffer& picture);

 private:
  FarthestSquares squares_;
  GlRenderbuffer texels_;
  GlFramebuffer framebuffer_;
  uint32_t columns_ = 0, rows_ = 0;
};

/// Depth pyramid of a picture on the GPU. Level 0 has one texel per square of FarthestDepths. Each texel of a
/// coarser level holds the farthest depth of 2 × 2 texels of the next finer level. A shader tests a box at
/// the level where the box covers at most 4 × 4 texels. Create, use and destroy the object on the thread of
/// its OpenGL context. Source: Greene, Kass and Miller, Hierarchical Z-buffer Visibility, 1993.
class DepthPyramid {
 public:
  /// @throws Error kInternal if the driver rejects a shader.
  DepthPyramid();

  /// Builds the pyramid without blocking. Changes the same state as FarthestSquares::draw().
  void build(const Framebuffer& picture);

  /// Returns the texture of reversed depths (1 is nearest). Texels outside the picture are 1, so that they
  /// never make a box visible.
  GLuint texture() const noexcept { return texture_.get(); }
  /// Returns the width of the picture, or 0 before the first build().
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
