#include "client/render/gl/framebuffer.h"

#include <algorithm>
#include <string>

#include "common/error.h"

namespace lode::render {
namespace {

[[noreturn]] void failSize(uint32_t width_px, uint32_t height_px, int limit_px) {
  throw Error(ErrorCode::kUsage, "a picture of " + std::to_string(width_px) + "x" +
                                     std::to_string(height_px) +
                                     " pixels cannot be drawn here; choose a --size between 1x1 and " +
                                     std::to_string(limit_px) + "x" + std::to_string(limit_px));
}

}  // namespace

Framebuffer::Framebuffer(uint32_t width_px, uint32_t height_px, int samples)
    : width_px_(width_px), height_px_(height_px) {
  GLint limit_px = 0, limit_samples = 1, limit_depth_samples = 1;
  glGetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &limit_px);
  glGetIntegerv(GL_MAX_SAMPLES, &limit_samples);
  glGetIntegerv(GL_MAX_DEPTH_TEXTURE_SAMPLES, &limit_depth_samples);
  const auto limit = static_cast<uint32_t>(limit_px);
  if (width_px == 0 || height_px == 0 || width_px > limit || height_px > limit) {
    failSize(width_px, height_px, limit_px);
  }
  const GLsizei width = static_cast<GLsizei>(width_px), height = static_cast<GLsizei>(height_px);
  samples_ = std::clamp(samples, 1, std::min(limit_samples, limit_depth_samples));
  while (glGetError() != GL_NO_ERROR) {
  }

  colour_ = GlRenderbuffer::create();
  drawn_ = GlFramebuffer::create();
  if (samples_ > 1) {
    makeSampled(width, height);
  } else {
    makePlain(width, height);
  }
  glNamedFramebufferRenderbuffer(drawn_.get(), GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, colour_.get());
  glNamedFramebufferTexture(drawn_.get(), GL_DEPTH_ATTACHMENT, depth(), 0);
  bool complete = true;
  for (const GLuint framebuffer : {drawn_.get(), resolved()}) {
    complete = complete &&
               glCheckNamedFramebufferStatus(framebuffer, GL_DRAW_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
  }
  if (glGetError() != GL_NO_ERROR || !complete) failSize(width_px, height_px, limit_px);
  constexpr float kBlack[4] = {0, 0, 0, 1};  // clear the storage, because new storage has undefined contents
  glClearNamedFramebufferfv(drawn_.get(), GL_COLOR, 0, kBlack);
}

void Framebuffer::makeSampled(GLsizei width, GLsizei height) {
  glNamedRenderbufferStorageMultisample(colour_.get(), samples_, GL_SRGB8_ALPHA8, width, height);
  glGetNamedRenderbufferParameteriv(colour_.get(), GL_RENDERBUFFER_SAMPLES, &samples_);
  sampled_depth_ = GlMultisampleTexture::create();
  glTextureStorage2DMultisample(sampled_depth_.get(), samples_, GL_DEPTH_COMPONENT32F, width, height,
                                GL_TRUE);
  resolved_colour_ = GlRenderbuffer::create();
  glNamedRenderbufferStorage(resolved_colour_.get(), GL_SRGB8_ALPHA8, width, height);
  resolved_ = GlFramebuffer::create();
  glNamedFramebufferRenderbuffer(resolved_.get(), GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER,
                                 resolved_colour_.get());
}

/// Allocates single-sample storage. If asked for multisample storage with one sample, Mesa would use its
/// default number of samples.
void Framebuffer::makePlain(GLsizei width, GLsizei height) {
  glNamedRenderbufferStorage(colour_.get(), GL_SRGB8_ALPHA8, width, height);
  plain_depth_ = GlTexture::create();
  glTextureStorage2D(plain_depth_.get(), 1, GL_DEPTH_COMPONENT32F, width, height);
  for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
    glTextureParameteri(plain_depth_.get(), filter, GL_NEAREST);
}

void Framebuffer::bindForDrawing() const {
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, drawn_.get());
  glViewport(0, 0, static_cast<GLsizei>(width_px_), static_cast<GLsizei>(height_px_));
}

void Framebuffer::resolve() const {
  if (samples_ == 1) return;
  const GLint width = static_cast<GLint>(width_px_), height = static_cast<GLint>(height_px_);
  glEnable(GL_FRAMEBUFFER_SRGB);
  glBlitNamedFramebuffer(drawn_.get(), resolved_.get(), 0, 0, width, height, 0, 0, width, height,
                         GL_COLOR_BUFFER_BIT, GL_NEAREST);
}

Image readFramebuffer(GLuint framebuffer, uint32_t width_px, uint32_t height_px) {
  Image image{width_px, height_px, {}};
  const size_t row_bytes = static_cast<size_t>(width_px) * 4;
  image.rgba.resize(row_bytes * height_px);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer);
  glPixelStorei(GL_PACK_ALIGNMENT, 4);
  glReadPixels(0, 0, static_cast<GLsizei>(width_px), static_cast<GLsizei>(height_px), GL_RGBA,
               GL_UNSIGNED_BYTE, image.rgba.data());
  for (uint32_t y = 0; y < height_px / 2; ++y) {
    uint8_t* top = image.rgba.data() + y * row_bytes;
    std::swap_ranges(top, top + row_bytes, image.rgba.data() + (height_px - 1 - y) * row_bytes);
  }
  return image;
}

void Framebuffer::copyTo(GLuint framebuffer, uint32_t width_px, uint32_t height_px) const {
  const GLint width = static_cast<GLint>(width_px_), height = static_cast<GLint>(height_px_);
  const bool has_same_size = width_px == width_px_ && height_px == height_px_;
  // The bytes are already sRGB, so copy them without conversion.
  glDisable(GL_FRAMEBUFFER_SRGB);
  glBlitNamedFramebuffer(resolved(), framebuffer, 0, 0, width, height, 0, 0, static_cast<GLint>(width_px),
                         static_cast<GLint>(height_px), GL_COLOR_BUFFER_BIT,
                         has_same_size ? GL_NEAREST : GL_LINEAR);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
}

}  // namespace lode::render
