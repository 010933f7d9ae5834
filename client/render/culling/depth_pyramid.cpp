#include "client/render/culling/depth_pyramid.h"

#include <algorithm>
#include <bit>

#include "client/render/culling/occluders.h"
#include "client/render/passes/shader_program.h"

namespace lode::render {
namespace {

constexpr GLuint kFinerUnit = 0, kCoarserUnit = 1;
constexpr GLsizei kGroupSide = 8;

const char* const kCoarserLevelShader = R"glsl(
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0, r32f) readonly uniform image2D finer;
layout(binding = 1, r32f) writeonly uniform image2D coarser;

float at(ivec2 place) { return imageLoad(finer, min(place, imageSize(finer) - 1)).r; }

void main() {
  ivec2 place = ivec2(gl_GlobalInvocationID.xy), first = place * 2;
  if (any(greaterThanEqual(place, imageSize(coarser)))) return;
  float farthest = min(min(at(first), at(first + ivec2(1, 0))), min(at(first + ivec2(0, 1)), at(first + 1)));
  imageStore(coarser, place, vec4(farthest));
}
)glsl";

}  // namespace

DepthPyramid::DepthPyramid() : coarser_program_(linkComputeProgram(kCoarserLevelShader)) {}

/// Of powers of two, so that each level halves the one before exactly.
void DepthPyramid::makeTexture(uint32_t columns, uint32_t rows) {
  const auto width = static_cast<GLsizei>(std::bit_ceil(columns));
  const auto height = static_cast<GLsizei>(std::bit_ceil(rows));
  if (width == texture_width_ && height == texture_height_) return;
  texture_width_ = width;
  texture_height_ = height;
  levels_ = std::bit_width(static_cast<unsigned>(std::max(width, height)));
  texture_ = GlTexture::create();
  glTextureStorage2D(texture_.get(), levels_, GL_R32F, width, height);
  glTextureParameteri(texture_.get(), GL_TEXTURE_MIN_FILTER, GL_NEAREST_MIPMAP_NEAREST);
  glTextureParameteri(texture_.get(), GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  framebuffer_ = GlFramebuffer::create();
  glNamedFramebufferTexture(framebuffer_.get(), GL_COLOR_ATTACHMENT0, texture_.get(), 0);
}

void DepthPyramid::build(const Framebuffer& picture) {
  const uint32_t columns = squareCount(picture.widthPx()), rows = squareCount(picture.heightPx());
  makeTexture(columns, rows);
  width_px_ = picture.widthPx();
  height_px_ = picture.heightPx();
  const GLfloat hides_all = 1;
  glClearTexImage(texture_.get(), 0, GL_RED, GL_FLOAT, &hides_all);
  squares_.draw(picture, framebuffer_.get());
  glUseProgram(coarser_program_.get());
  GLsizei width = texture_width_, height = texture_height_;
  for (GLint level = 1; level < levels_; ++level) {
    width = std::max(1, width / 2);
    height = std::max(1, height / 2);
    glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
    glBindImageTexture(kFinerUnit, texture_.get(), level - 1, GL_FALSE, 0, GL_READ_ONLY, GL_R32F);
    glBindImageTexture(kCoarserUnit, texture_.get(), level, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32F);
    glDispatchCompute(static_cast<GLuint>((width + kGroupSide - 1) / kGroupSide),
                      static_cast<GLuint>((height + kGroupSide - 1) / kGroupSide), 1);
  }
  glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
}

}  // namespace lode::render
