#include "client/render/culling/depth_pyramid.h"

#include <algorithm>
#include <array>
#include <bit>
#include <string_view>

#include "client/render/culling/occluders.h"
#include "client/render/gl/shader_program.h"

namespace lode::render {
namespace {

constexpr GLuint kDepthUnit = 1;
constexpr std::array<std::string_view, 1> kSampled{"SAMPLED"};

const char* const kFarthestFragmentShader = R"glsl(
#ifdef SAMPLED
layout(binding = 1) uniform sampler2DMS depths;
layout(location = 0) uniform int samples;
ivec2 sizePx() { return textureSize(depths); }
#else
layout(binding = 1) uniform sampler2D depths;
const int samples = 1;
ivec2 sizePx() { return textureSize(depths, 0); }
#endif
out float farthest;

const int kSquarePx = 8;

void main() {
  ivec2 first = ivec2(gl_FragCoord.xy) * kSquarePx;
  ivec2 end = min(first + kSquarePx, sizePx());
  farthest = 1.0;
  for (int y = first.y; y < end.y; ++y)
    for (int x = first.x; x < end.x; ++x)
      for (int number = 0; number < samples; ++number)
        farthest = min(farthest, texelFetch(depths, ivec2(x, y), number).r);
}
)glsl";

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

uint32_t squareCount(uint32_t side_px) noexcept {
  return (side_px + FarthestDepths::kSquarePx - 1) / FarthestDepths::kSquarePx;
}

FarthestSquares::FarthestSquares()
    : plain_program_(linkProgram(kFullScreenVertexShader, {kFarthestFragmentShader})),
      sampled_program_(linkProgram(kFullScreenVertexShader, {kFarthestFragmentShader}, kSampled)),
      empty_array_(GlVertexArray::create()) {}

void FarthestSquares::draw(const Framebuffer& picture, GLuint framebuffer) {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glViewport(0, 0, static_cast<GLsizei>(squareCount(picture.widthPx())),
             static_cast<GLsizei>(squareCount(picture.heightPx())));
  glDisable(GL_DEPTH_TEST);
  const bool has_samples = picture.samples() > 1;
  glUseProgram(has_samples ? sampled_program_.get() : plain_program_.get());
  if (has_samples) glUniform1i(0, picture.samples());
  glBindTextureUnit(kDepthUnit, picture.depth());
  glBindVertexArray(empty_array_.get());
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

FarthestDepths DepthReader::read(const Framebuffer& picture) {
  FarthestDepths farthest{squareCount(picture.widthPx()), squareCount(picture.heightPx()), {}};
  const auto columns = static_cast<GLsizei>(farthest.columns), rows = static_cast<GLsizei>(farthest.rows);
  if (farthest.columns != columns_ || farthest.rows != rows_) {
    columns_ = farthest.columns;
    rows_ = farthest.rows;
    texels_ = GlRenderbuffer::create();
    glNamedRenderbufferStorage(texels_.get(), GL_R32F, columns, rows);
    framebuffer_ = GlFramebuffer::create();
    glNamedFramebufferRenderbuffer(framebuffer_.get(), GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, texels_.get());
  }
  squares_.draw(picture, framebuffer_.get());
  farthest.depths.resize(size_t{farthest.columns} * farthest.rows);
  glPixelStorei(GL_PACK_ALIGNMENT, 4);
  glReadPixels(0, 0, columns, rows, GL_RED, GL_FLOAT, farthest.depths.data());
  return farthest;
}

DepthPyramid::DepthPyramid() : coarser_program_(linkComputeProgram(kCoarserLevelShader)) {}

/// Creates a texture with power-of-two sides, so that each level is exactly half as wide and high as the next
/// finer level.
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
