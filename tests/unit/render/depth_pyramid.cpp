#include "client/render/culling/depth_pyramid.h"

#include <algorithm>

#include "client/render/renderer.h"
#include "gl_fixture.h"
#include "tests/support/test_meshes.h"

namespace lode::test {
namespace {

using render::FarthestDepths;

using DepthPyramidTest = GlTest;

std::vector<float> levelOf(const render::DepthPyramid& pyramid, GLint level, GLint& width) {
  GLint height = 0;
  glGetTextureLevelParameteriv(pyramid.texture(), level, GL_TEXTURE_WIDTH, &width);
  glGetTextureLevelParameteriv(pyramid.texture(), level, GL_TEXTURE_HEIGHT, &height);
  std::vector<float> texels(static_cast<size_t>(width) * static_cast<size_t>(height));
  glGetTextureImage(pyramid.texture(), level, GL_RED, GL_FLOAT,
                    static_cast<GLsizei>(texels.size() * sizeof(float)), texels.data());
  return texels;
}

float farthestOf(const FarthestDepths& depths, uint32_t column, uint32_t row, uint32_t side) {
  float farthest = 1;
  for (uint32_t y = row * side; y < std::min((row + 1) * side, depths.rows); ++y)
    for (uint32_t x = column * side; x < std::min((column + 1) * side, depths.columns); ++x)
      farthest = std::min(farthest, depths.depths[size_t{y} * depths.columns + x]);
  return farthest;
}

TEST_F(DepthPyramidTest, storesTheFarthestDepthOfEachSquareOnEveryLevel) {
  render::Renderer renderer;
  renderer.show(
      cutOf({makeSphere(40, 30, {.attributes = {AttributeSet::kNormal}, .origin = {500, 500, 500}})}));
  renderer.uploadInRenderThread({.wait = true});
  render::DepthPyramid pyramid;
  render::DepthReader reader;
  for (const auto& [width_px, height_px] : {std::pair{333u, 250u}, {64u, 130u}, {1u, 1u}, {640u, 90u}}) {
    core::View view = lookAt({2500, 2500, 9000}, {2500, 2500, 2500});
    view.width_px = width_px;
    view.height_px = height_px;
    const render::Framebuffer target(width_px, height_px);
    renderer.draw(view, target);
    const FarthestDepths depths = reader.read(target);
    pyramid.build(target);
    uint32_t side = 1;
    for (GLint level = 0, width = 0; side < 2 * std::max(depths.columns, depths.rows); ++level, side *= 2) {
      const std::vector<float> texels = levelOf(pyramid, level, width);
      for (uint32_t row = 0; row * side < depths.rows; ++row)
        for (uint32_t column = 0; column * side < depths.columns; ++column)
          EXPECT_EQ(texels[size_t{row} * static_cast<size_t>(width) + column],
                    farthestOf(depths, column, row, side))
              << width_px << " pixels, level " << level << ", " << column << ", " << row;
    }
  }
}

}  // namespace
}  // namespace lode::test
