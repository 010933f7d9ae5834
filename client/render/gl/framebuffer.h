#pragma once

#include <cstdint>

#include "client/render/gl/gl_names.h"
#include "client/render/gl/image.h"

namespace lode::render {

/// Reads the colours of a framebuffer with one sample per pixel. Framebuffer 0 is the window; its current
/// read buffer is used.
Image readFramebuffer(GLuint framebuffer, uint32_t width_px, uint32_t height_px);

/// An off-screen render target with sRGB colour and reversed 32-bit float depth. A multisampled target also
/// has a resolved colour buffer. Use the object on the thread of its OpenGL context.
class Framebuffer {
 public:
  /// @param samples  samples per pixel, clamped to the driver's limit. The driver may raise any value
  /// except 1.
  /// @throws Error kUsage if the driver does not support this size.
  Framebuffer(uint32_t width_px, uint32_t height_px, int samples = 4);

  uint32_t widthPx() const noexcept { return width_px_; }
  uint32_t heightPx() const noexcept { return height_px_; }
  int samples() const noexcept { return samples_; }
  /// Returns the depth texture, which is multisampled if samples() > 1.
  GLuint depth() const noexcept { return samples_ > 1 ? sampled_depth_.get() : plain_depth_.get(); }

  /// Binds this target as the draw framebuffer and sets the viewport to its size.
  void bindForDrawing() const;
  /// Averages the samples. Call it after drawing, before readPixels() and copyTo().
  void resolve() const;
  Image readPixels() const { return readFramebuffer(resolved(), width_px_, height_px_); }
  /// Copies the resolved picture to a framebuffer; 0 is the window. If the sizes differ, scales the picture
  /// with linear filtering. Leaves the framebuffer bound for drawing and for reading: if a window is bound
  /// for reading only after it was drawn, Mesa reads black.
  void copyTo(GLuint framebuffer, uint32_t width_px, uint32_t height_px) const;

 private:
  GLuint resolved() const noexcept { return samples_ > 1 ? resolved_.get() : drawn_.get(); }
  void makeSampled(GLsizei width, GLsizei height);
  void makePlain(GLsizei width, GLsizei height);

  uint32_t width_px_, height_px_;
  int samples_ = 1;
  GlRenderbuffer colour_, resolved_colour_;
  GlMultisampleTexture sampled_depth_;
  GlTexture plain_depth_;
  GlFramebuffer drawn_, resolved_;
};

}  // namespace lode::render
