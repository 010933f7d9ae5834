#include "client/render/depth_reader.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "client/render/shader_program.h"
#include "client/render/shaders.h"

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

}  // namespace

bool drawsInSoftware() {
  const std::string_view name = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  constexpr std::array<std::string_view, 3> kSoftware{"llvmpipe", "softpipe", "SwiftShader"};
  return std::ranges::any_of(
      kSoftware, [&](std::string_view known) { return name.find(known) != std::string_view::npos; });
}

DepthReader::DepthReader()
    : plain_program_(linkProgram(kWholeVertexShader, {kFarthestFragmentShader})),
      sampled_program_(linkProgram(kWholeVertexShader, {kFarthestFragmentShader}, kSampled)),
      empty_array_(GlVertexArray::create()) {}

FarthestDepths DepthReader::read(const Framebuffer& picture) {
  constexpr uint32_t kSquarePx = FarthestDepths::kSquarePx;
  FarthestDepths farthest{
      (picture.widthPx() + kSquarePx - 1) / kSquarePx, (picture.heightPx() + kSquarePx - 1) / kSquarePx, {}};
  const auto columns = static_cast<GLsizei>(farthest.columns), rows = static_cast<GLsizei>(farthest.rows);
  if (farthest.columns != columns_ || farthest.rows != rows_) {
    columns_ = farthest.columns;
    rows_ = farthest.rows;
    squares_ = GlRenderbuffer::create();
    glNamedRenderbufferStorage(squares_.get(), GL_R32F, columns, rows);
    framebuffer_ = GlFramebuffer::create();
    glNamedFramebufferRenderbuffer(framebuffer_.get(), GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, squares_.get());
  }
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.get());
  glViewport(0, 0, columns, rows);
  glDisable(GL_DEPTH_TEST);
  const bool has_samples = picture.samples() > 1;
  glUseProgram(has_samples ? sampled_program_.get() : plain_program_.get());
  if (has_samples) glUniform1i(0, picture.samples());
  glBindTextureUnit(kDepthUnit, picture.depth());
  glBindVertexArray(empty_array_.get());
  glDrawArrays(GL_TRIANGLES, 0, 3);
  farthest.depths.resize(size_t{farthest.columns} * farthest.rows);
  glPixelStorei(GL_PACK_ALIGNMENT, 4);
  glReadPixels(0, 0, columns, rows, GL_RED, GL_FLOAT, farthest.depths.data());
  return farthest;
}

}  // namespace lode::render
