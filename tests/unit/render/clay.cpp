#include <set>

#include "client/render/passes/color_mode.h"
#include "client/render/passes/light.h"
#include "gl_fixture.h"
#include "tests/support/test_meshes.h"

namespace lode::test {
namespace {

using render::ColorMode;

/// Draws a sphere from +z.
class Clay : public GlTest {
 protected:
  static render::Image sphere(render::DrawStyle style, std::optional<glm::u8vec4> paint = {}) {
    Mesh mesh = makeSphere(48, 24, {.attributes = {AttributeSet::kNormal}, .bump = 0});
    if (paint) {
      mesh.attributes.bits |= AttributeSet::kColour;
      for (VertexAttributes& attributes : mesh.vertex_attributes) attributes.colour = *paint;
    }
    return drawMeshes({mesh}, 1, lookAt({2048, 2048, 9000}, {2048, 2048, 2048}), style);
  }
  static render::DrawStyle showing(ColorMode show) {
    render::DrawStyle style = magentaBehind();
    style.show = show;
    return style;
  }
  static std::set<int> greensOf(const render::Image& image) {
    std::set<int> greens;
    for (uint32_t y = 0; y < image.height_px; ++y)
      for (uint32_t x = 0; x < image.width_px; ++x)
        if (!showsMagenta(image.pixel(x, y))) greens.insert(image.pixel(x, y)[1]);
    return greens;
  }
};

TEST_F(Clay, isMidGreyWhateverTheModelsPaint) {
  const render::Image plain = sphere(showing(ColorMode::kClay));
  const std::set<int> greens = greensOf(plain);
  EXPECT_LT(*greens.rbegin(), 185) << "no part is near white";
  EXPECT_GT(*greens.rbegin(), 110);
  EXPECT_GT(*greens.rbegin() - *greens.begin(), 60) << "its shape is seen";
  EXPECT_EQ(sphere(showing(ColorMode::kClay), glm::u8vec4(20, 200, 30, 255)).rgba, plain.rgba);
}

TEST_F(Clay, asMatcapDependsOnTheViewAlone) {
  render::DrawStyle style = showing(ColorMode::kMatcap);
  const render::Image upright = sphere(style);
  style.up = {1, 0, 0};
  EXPECT_EQ(sphere(style).rgba, upright.rgba);
  EXPECT_EQ(sphere(style, glm::u8vec4(20, 200, 30, 255)).rgba, upright.rgba);
  EXPECT_GT(greensOf(upright).size(), 60u);
}

TEST_F(Clay, isLitFromWhereTheSunIsTurned) {
  render::DrawStyle style = showing(ColorMode::kClay);
  const auto leftMinusRight = [&] {
    const render::Image image = sphere(style);
    const uint32_t y = kHeightPx / 2, aside = kHeightPx / 5;
    return int{image.pixel(kWidthPx / 2 - aside, y)[1]} - int{image.pixel(kWidthPx / 2 + aside, y)[1]};
  };
  EXPECT_GT(leftMinusRight(), 10);
  style.sun_turn_rad = {1.5, 0};
  EXPECT_LT(leftMinusRight(), -10);
}

TEST(SunTurn, movesTheSunToTheRightAndDown) {
  const core::View view = lookAt({0, 0, 5}, {0, 0, 0});
  const glm::vec3 sun = render::lightFor(view, {0, 1, 0}).to_sun;
  const glm::vec3 right = render::lightFor(view, {0, 1, 0}, {0.3, 0}).to_sun;
  const glm::vec3 lower = render::lightFor(view, {0, 1, 0}, {0, 0.3}).to_sun;
  EXPECT_GT(right.x, sun.x + 0.1f);
  EXPECT_FLOAT_EQ(right.y, sun.y);
  EXPECT_LT(lower.y, sun.y - 0.1f);
  EXPECT_NEAR(glm::length(lower), 1, 1e-5);
}

}  // namespace
}  // namespace lode::test
