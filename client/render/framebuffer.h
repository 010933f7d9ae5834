#pragma once

#include <cstdint>

#include "client/render/gl_names.h"
#include "client/render/image.h"

namespace lode::render {

/// The colours of a framebuffer of one sample a pixel (0: the window's, from its chosen read buffer).
Image readFramebuffer(GLuint framebuffer, uint32_t width_px, uint32_t height_px);

/// A picture in the making: sRGB colour and reversed 32-bit float depth, and where a pixel has several
/// samples the resolved colour beside it. Used on the thread of its context.
class Framebuffer {
 public:
  /// @param samples  a pixel; lowered to what the driver has, and raised where it has none so few, but never
  ///                 from one.
  /// @throws Error kUsage if the driver cannot make a picture of this size.
  Framebuffer(uint32_t width_px, uint32_t height_px, int samples = 4);

  uint32_t widthPx() const noexcept { return width_px_; }
  uint32_t heightPx() const noexcept { return height_px_; }
  int samples() const noexcept { return samples_; }
  /// A texture, of several samples a pixel where it has several.
  GLuint depth() const noexcept { return samples_ > 1 ? sampled_depth_.get() : plain_depth_.get(); }

  /// What is drawn from now on goes here.
  void bindForDrawing() const;
  /// Averages the samples. To be called after drawing, before readPixels() and copyTo().
  void resolve() const;
  Image readPixels() const { return readFramebuffer(resolved(), width_px_, height_px_); }
  /// Copies the resolved picture to a framebuffer of this size (0: the window), blended between pixels where
  /// that has another, and leaves that one bound for drawing and for reading: Mesa reads black of a window
  /// that was bound for reading only when it had been drawn.
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
