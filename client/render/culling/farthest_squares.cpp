#include "client/render/culling/farthest_squares.h"

#include <array>
#include <string_view>

#include "client/render/culling/occluders.h"
#include "client/render/passes/shader_program.h"
#include "client/render/passes/shaders.h"

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

uint32_t squareCount(uint32_t side_px) noexcept {
  return (side_px + FarthestDepths::kSquarePx - 1) / FarthestDepths::kSquarePx;
}

FarthestSquares::FarthestSquares()
    : plain_program_(linkProgram(kWholeVertexShader, {kFarthestFragmentShader})),
      sampled_program_(linkProgram(kWholeVertexShader, {kFarthestFragmentShader}, kSampled)),
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

}  // namespace lode::render
