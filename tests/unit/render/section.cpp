#include "client/render/passes/section.h"

#include <algorithm>

#include "gl_fixture.h"
#include "tests/support/test_meshes.h"

namespace lode::test {
namespace {

/// Draws a sphere of radius 2048 around (2048, 2048, 2048) from +z.
class Sections : public GlTest {
 protected:
  static render::Image sphere(const std::optional<render::Section>& section) {
    render::DrawStyle style = magentaBehind();
    style.section = section;
    const Mesh mesh = makeSphere(48, 24, {.attributes = {AttributeSet::kNormal}, .bump = 0});
    return drawMeshes({mesh}, 1, lookAt({2048, 2048, 9000}, {2048, 2048, 2048}), style);
  }
  static const uint8_t* middleOf(const render::Image& image) {
    return image.pixel(kWidthPx / 2, kHeightPx / 2);
  }
};

TEST_F(Sections, showTheCutOfASolidInOneColour) {
  const render::Image cut = sphere(render::Section{{0, 0, 1}, 2048, {0, 0, 1}});
  const render::Image whole = sphere({});
  int blue = 0, other = 0;
  for (uint32_t y = 0; y < kHeightPx; ++y)
    for (uint32_t x = 0; x < kWidthPx; ++x) {
      const uint8_t* const pixel = cut.pixel(x, y);
      if (showsMagenta(pixel)) continue;
      (pixel[2] > 250 && pixel[0] < 5 && pixel[1] < 5 ? blue : other) += 1;
    }
  EXPECT_GT(blue, 1000);
  EXPECT_LT(other, blue / 10) << "at most the rim";
  EXPECT_NE(middleOf(whole)[0], middleOf(cut)[0]);
}

TEST_F(Sections, showTheOutsideBesideTheCut) {
  render::DrawStyle style = magentaBehind();
  style.section = render::Section{{1, 0, 0}, 2048, {0, 0, 1}};
  const Mesh mesh = makeSphere(48, 24, {.attributes = {AttributeSet::kNormal}, .bump = 0});
  const render::Image cut = drawMeshes({mesh}, 1, lookAt({6000, 2048, 8000}, {2048, 2048, 2048}), style);
  int blue = 0, outside = 0;
  for (uint32_t y = 0; y < kHeightPx; ++y)
    for (uint32_t x = 0; x < kWidthPx; ++x) {
      const uint8_t* const pixel = cut.pixel(x, y);
      if (showsMagenta(pixel)) continue;
      (pixel[2] > 250 && pixel[0] < 5 && pixel[1] < 5 ? blue : outside) += 1;
    }
  EXPECT_GT(blue, 500);
  EXPECT_GT(outside, 500);
}

TEST_F(Sections, leaveTheShownHalfAsItIs) {
  const render::Image cut = sphere(render::Section{{1, 0, 0}, 2048}), whole = sphere({});
  for (uint32_t y = 0; y < kHeightPx; ++y) {
    for (uint32_t x = 0; x < kWidthPx / 2 - 2; ++x)
      ASSERT_EQ(cut.pixel(x, y)[1], whole.pixel(x, y)[1]) << x << ", " << y;
    ASSERT_TRUE(showsMagenta(cut.pixel(kWidthPx / 2 + 10, y))) << y;
  }
}

TEST_F(Sections, haveNoEdgesOfTrianglesOnTheCut) {
  const Mesh mesh = makeSphere(48, 24, {.attributes = {AttributeSet::kNormal}, .bump = 0});
  const auto imageOf = [&](render::ColorMode show, bool cuts) {
    render::DrawStyle style = magentaBehind();
    style.show = show;
    if (cuts) style.section = render::Section{{1, 0, 0}, 2048, {0, 0, 1}};
    return drawMeshes({mesh}, 1, lookAt({6000, 2048, 8000}, {2048, 2048, 2048}), style);
  };
  using enum render::ColorMode;
  const render::Image surface = imageOf(kSurface, true), wireframe = imageOf(kWireframe, true);
  int blue = 0, edges = 0;
  for (uint32_t y = 0; y < kHeightPx; ++y)
    for (uint32_t x = 0; x < kWidthPx; ++x) {
      const uint8_t *const plain = surface.pixel(x, y), *const wired = wireframe.pixel(x, y);
      const bool is_on_cut = plain[2] > 250 && plain[0] < 5 && plain[1] < 5;
      EXPECT_TRUE(!is_on_cut || std::equal(plain, plain + 3, wired)) << x << ", " << y;
      blue += is_on_cut;
      edges += !is_on_cut && wired[1] < plain[1];
    }
  EXPECT_GT(blue, 500);
  EXPECT_GT(edges, 100) << "on the outside beside the cut";
}

TEST_F(Sections, showTheInsideOfAnOpenSurfaceToAnEyeOnItsSide) {
  const render::Image behind = sphere(render::Section{{0, 0, -1}, -2048, {0, 0, 1}});
  const uint8_t* const pixel = middleOf(behind);
  EXPECT_EQ(pixel[0], middleOf(sphere({}))[0]) << "the front half, from outside";
}

}  // namespace
}  // namespace lode::test
