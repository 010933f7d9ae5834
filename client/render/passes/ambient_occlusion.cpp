#include "client/render/passes/ambient_occlusion.h"

#include <cmath>

#include "client/render/passes/ambient_occlusion_shaders.h"
#include "client/render/passes/shader_program.h"
#include "client/render/passes/shaders.h"

namespace lode::render {
namespace {

/// How far what hides the sky may be, as a share of the picture's height.
constexpr float kReach = 0.07f;

enum HalfUnit : GLuint { kPictureDepth = 1, kHalfLayer };

}  // namespace

AmbientOcclusion::AmbientOcclusion()
    : halving_program_(linkProgram(kWholeVertexShader, {kHalvingShader})),
      occlusion_program_(linkProgram(kWholeVertexShader, {kOcclusionShader})),
      blur_program_(linkProgram(kWholeVertexShader, {kOcclusionBlurShader})),
      darkening_program_(linkProgram(kWholeVertexShader, {kDarkeningShader})),
      empty_array_(GlVertexArray::create()) {}

AmbientOcclusion::Layer AmbientOcclusion::makeLayer(GLenum format, uint32_t width_px, uint32_t height_px) {
  Layer layer{GlTexture::create(), GlFramebuffer::create()};
  const GLuint texture = layer.texture.get();
  glTextureStorage2D(texture, 1, format, static_cast<GLsizei>(width_px), static_cast<GLsizei>(height_px));
  for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
    glTextureParameteri(texture, filter, GL_NEAREST);
  for (const GLenum wrap : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
    glTextureParameteri(texture, wrap, GL_CLAMP_TO_EDGE);
  glNamedFramebufferTexture(layer.framebuffer.get(), GL_COLOR_ATTACHMENT0, texture, 0);
  return layer;
}

void AmbientOcclusion::fit(const Framebuffer& picture) {
  const uint32_t width_px = (picture.widthPx() + 1) / 2, height_px = (picture.heightPx() + 1) / 2;
  if (width_px == width_px_ && height_px == height_px_) return;
  width_px_ = width_px;
  height_px_ = height_px;
  depth_ = makeLayer(GL_R32F, width_px, height_px);
  occlusion_ = makeLayer(GL_RG32F, width_px, height_px);
  blurred_ = makeLayer(GL_RG32F, width_px, height_px);
}

void AmbientOcclusion::drawLayer(const Layer& layer, const GlProgram& program) const {
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, layer.framebuffer.get());
  glUseProgram(program.get());
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

/// Of the depth that is bound.
void AmbientOcclusion::drawLayers() const {
  glDisable(GL_DEPTH_TEST);
  glViewport(0, 0, static_cast<GLsizei>(width_px_), static_cast<GLsizei>(height_px_));
  drawLayer(depth_, halving_program_);
  glBindTextureUnit(kHalfLayer, depth_.texture.get());
  drawLayer(occlusion_, occlusion_program_);
  glBindTextureUnit(kHalfLayer, occlusion_.texture.get());
  glProgramUniform2i(blur_program_.get(), kBlurAlong, 1, 0);
  drawLayer(blurred_, blur_program_);
  glBindTextureUnit(kHalfLayer, blurred_.texture.get());
  glProgramUniform2i(blur_program_.get(), kBlurAlong, 0, 1);
  drawLayer(occlusion_, blur_program_);
  glBindTextureUnit(kHalfLayer, occlusion_.texture.get());
}

void AmbientOcclusion::darken(const Framebuffer& picture, double fov_y_rad, ColorMode show) {
  if (show != ColorMode::kSurface) return;
  fit(picture);
  const float half_height = 0.5f * static_cast<float>(picture.heightPx());
  const glm::vec2 middle_px = 0.25f * glm::vec2(picture.widthPx(), picture.heightPx());
  const auto ray_step = static_cast<float>(2 * std::tan(fov_y_rad / 2) / half_height);
  glProgramUniform2f(occlusion_program_.get(), kOcclusionMiddle, middle_px.x, middle_px.y);
  glProgramUniform1f(occlusion_program_.get(), kOcclusionRayStep, ray_step);
  glProgramUniform1f(occlusion_program_.get(), kOcclusionReach, kReach * half_height);

  glBindVertexArray(empty_array_.get());
  glBindTextureUnit(kPictureDepth, picture.depth());
  drawLayers();

  picture.bindForDrawing();
  glEnable(GL_FRAMEBUFFER_SRGB);
  glEnable(GL_BLEND);
  glBlendFunc(GL_ZERO, GL_SRC_COLOR);
  glEnable(GL_DEPTH_TEST);
  glDepthMask(GL_FALSE);
  glDepthFunc(GL_LESS);  // than that of the background: samples of it are left out
  glUseProgram(darkening_program_.get());
  glProgramUniform1i(darkening_program_.get(), kDarkeningSamples, picture.samples());
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glDepthMask(GL_TRUE);
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_BLEND);
  glBindVertexArray(0);
}

}  // namespace lode::render
