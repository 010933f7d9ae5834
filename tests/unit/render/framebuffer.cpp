#include "client/render/gl/framebuffer.h"

#include <algorithm>
#include <utility>

#include <gtest/gtest.h>

#include "gl_fixture.h"

namespace lode::test {
namespace {

using Samples = GlTest;

/// A square with edges diagonal to the pixels, in front of magenta.
render::Image slantedSquare(const render::Framebuffer& target) {
  const core::View view = lookAt({2000, 2000, 4000}, {2000, 2000, 1000}, {0.2, 1, 0});
  render::Renderer renderer;
  renderer.show(GlTest::cutOf(std::vector{squareAt(1500, 1500, 1000, 1000, {255, 255, 0, 255})}));
  renderer.uploadInRenderThread({.wait = true});
  render::DrawStyle style = GlTest::magentaBehind();
  style.show = render::ColorMode::kUnlit;
  renderer.draw(view, target, style);
  target.resolve();
  return target.readPixels();
}

/// Counts pixels of neither the square's nor the background's colour.
int mixedPixels(const render::Image& image) {
  int mixed = 0;
  for (size_t i = 0; i < image.rgba.size(); i += 4) {
    const bool is_square = image.rgba[i + 1] == 255 && image.rgba[i + 2] == 0;
    mixed += !is_square && !isMagenta(&image.rgba[i]);
  }
  return mixed;
}

TEST_F(Samples, areMixedUnlessThereIsOnlyOne) {
  const render::Framebuffer several(kWidthPx, kHeightPx), one(kWidthPx, kHeightPx, 1);
  const render::Image mixed = slantedSquare(several), plain = slantedSquare(one);
  EXPECT_GT(mixedPixels(mixed), 50);
  EXPECT_EQ(mixedPixels(plain), 0);
  EXPECT_EQ(one.samples(), 1);
  for (const auto& [x, y] : {std::pair{0u, 0u}, {kWidthPx / 2, kHeightPx / 2}})
    EXPECT_TRUE(std::equal(plain.pixel(x, y), plain.pixel(x, y) + 4, mixed.pixel(x, y)));
}

TEST_F(Samples, areAsManyAsReported) {
  for (const int asked : {1, 2, 4}) {
    const render::Framebuffer target(kWidthPx, kHeightPx, asked);
    target.bindForDrawing();
    GLint samples = 0;
    glGetFramebufferParameteriv(GL_DRAW_FRAMEBUFFER, GL_SAMPLES, &samples);
    EXPECT_EQ(target.samples(), std::max(samples, 1)) << asked;
  }
}

TEST_F(Samples, areBlendedWhereAPictureIsCopiedToMorePixels) {
  const render::Framebuffer target(kWidthPx, kHeightPx, 1);
  const render::Image drawn = slantedSquare(target);
  constexpr uint32_t kWide = 2 * kWidthPx, kHigh = 2 * kHeightPx;
  const render::GlRenderbuffer colours = render::GlRenderbuffer::create();
  glNamedRenderbufferStorage(colours.get(), GL_RGBA8, GLsizei{kWide}, GLsizei{kHigh});
  const render::GlFramebuffer window = render::GlFramebuffer::create();
  glNamedFramebufferRenderbuffer(window.get(), GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, colours.get());
  target.copyTo(window.get(), kWide, kHigh);
  const render::Image copied = render::readFramebuffer(window.get(), kWide, kHigh);
  EXPECT_GT(mixedPixels(copied), 50);
  for (const auto& [x, y] : {std::pair{0u, 0u}, {kWidthPx - 1, kHeightPx - 1}, {kWidthPx / 2, kHeightPx / 2}})
    EXPECT_TRUE(std::equal(drawn.pixel(x, y), drawn.pixel(x, y) + 4, copied.pixel(2 * x, 2 * y)));
  target.copyTo(window.get(), kWidthPx, kHeightPx);
  EXPECT_EQ(render::readFramebuffer(window.get(), kWidthPx, kHeightPx).rgba, drawn.rgba);
}

}  // namespace
}  // namespace lode::test
