#include "client/render/passes/ambient_occlusion.h"

#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "gl_fixture.h"
#include "tests/support/test_meshes.h"

namespace lode::test {
namespace {

using Occlusion = GlTest;

const glm::u8vec4 kGrey(180, 180, 180, 255);

Mesh quad(const std::array<glm::uvec3, 4>& corners, glm::u8vec4 colour = kGrey) {
  Mesh mesh;
  mesh.attributes.bits = AttributeSet::kColour;
  for (const glm::uvec3& corner : corners) {
    mesh.positions.push_back(packPosition(corner));
    mesh.vertex_attributes.push_back({0, 0, colour, {}});
  }
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

/// A floor and a wall on its edge, 4000 steps wide; the crease is at y = 0, z = 0 of the corner.
std::vector<Mesh> floorAndWall(uint32_t scale = 1, uint32_t wall_height = 4000, glm::u8vec4 colour = kGrey) {
  const uint32_t side = 4000 * scale, height = wall_height * scale;
  return {quad({{{0, 0, 0}, {side, 0, 0}, {side, side, 0}, {0, side, 0}}}, colour),
          quad({{{0, side, 0}, {side, side, 0}, {side, side, height}, {0, side, height}}}, colour)};
}

/// Looks straight at the crease of floorAndWall() from 45 degrees above the floor.
core::View atCrease(double scale = 1) {
  const glm::dvec3 crease(2000 * scale, 4000 * scale, 0);
  return lookAt(crease + glm::dvec3(0, -3000, 3000) * scale, crease, {0, 0, 1});
}

/// A picture without and with ambient occlusion.
struct Pair {
  render::Image before, after;

  double lightAt(const render::Image& image, uint32_t x, uint32_t y) const {
    return std::pow(image.pixel(x, y)[1] / 255.0, 2.2);
  }
  /// Ratio of the light with to without.
  double factor(uint32_t x, uint32_t y) const { return lightAt(after, x, y) / lightAt(before, x, y); }
  int largestChange() const {
    int largest = 0;
    for (size_t i = 0; i < before.rgba.size(); ++i)
      largest = std::max(largest, std::abs(int{before.rgba[i]} - int{after.rgba[i]}));
    return largest;
  }
};

std::unique_ptr<render::Renderer> rendererOf(const std::vector<Mesh>& meshes) {
  auto renderer = std::make_unique<render::Renderer>();
  renderer->show(GlTest::cutOf(meshes));
  renderer->uploadInRenderThread({.wait = true});
  return renderer;
}

render::Image resolved(const render::Framebuffer& target) {
  target.resolve();
  return target.readPixels();
}

Pair drawBoth(const std::vector<Mesh>& meshes, const core::View& view,
              const render::DrawStyle& style = GlTest::magentaBehind()) {
  const auto renderer = rendererOf(meshes);
  const render::Framebuffer target(view.width_px, view.height_px);
  renderer->draw(view, target, style);
  Pair pair{resolved(target), {}};
  render::AmbientOcclusion().darken(target, view.fov_y_rad, style.show);
  pair.after = resolved(target);
  EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
  return pair;
}

TEST_F(Occlusion, darkensACreaseAndNotTheOpenFloorAndWallBesideIt) {
  const Pair pair = drawBoth(floorAndWall(), atCrease());
  for (uint32_t x = 20; x < kWidthPx - 20; ++x) {
    for (const int away : {-1, 1}) {
      EXPECT_LT(pair.factor(x, kHeightPx / 2 + away), 0.85);
      EXPECT_GT(pair.factor(x, kHeightPx / 2 + away), 0.5);
      EXPECT_EQ(pair.factor(x, kHeightPx / 2 + 20 * away), 1);
    }
  }
}

TEST_F(Occlusion, isStrongestInTheCreaseAndFadesAwayFromIt) {
  const Pair pair = drawBoth(floorAndWall(), atCrease());
  for (const int away : {-1, 1})
    for (int y = 1; y < 18; ++y)
      EXPECT_LE(pair.factor(kWidthPx / 2, kHeightPx / 2 + away * y),
                pair.factor(kWidthPx / 2, kHeightPx / 2 + away * (y + 1)) + 0.02);
}

TEST_F(Occlusion, reachesTheOutlineOfADarkenedSurface) {
  const Pair pair = drawBoth(floorAndWall(), atCrease());
  uint32_t first = 0;
  while (showsMagenta(pair.before.pixel(first, kHeightPx / 2))) ++first;
  EXPECT_GT(first, 5u);
  for (uint32_t x = first; x < first + 3; ++x) EXPECT_LT(pair.factor(x, kHeightPx / 2), 0.9) << x - first;
}

TEST_F(Occlusion, doesNotDarkenAPlaneAtAnyAngle) {
  const Mesh plane = makeGrid(60, 60, {.attributes = {AttributeSet::kColour}, .extent = 6000, .bump = 0});
  const glm::dvec3 middle(3000, 3000, 0);
  for (const double degrees : {90, 60, 30, 15, 7, 3, 1}) {
    for (const double aside : {0.0, 0.4, 1.3}) {
      const double angle = glm::radians(degrees);
      const glm::dvec3 away(std::cos(angle) * std::cos(aside), std::cos(angle) * std::sin(aside),
                            std::sin(angle));
      const Pair pair = drawBoth({plane}, lookAt(middle + 4000.0 * away, middle, {0.1, 0.9, 0.2}));
      EXPECT_LE(pair.largestChange(), 1) << degrees << " degrees, " << aside;
    }
  }
}

TEST_F(Occlusion, hardlyDarkensAPlaneThatFadesByAPixel) {
  const core::View view = lookAt({2000, 2000, 5000}, {2000, 2000, 1000});
  const double pixel = 2 * 4000 * std::tan(view.fov_y_rad / 2) / kHeightPx;
  const auto at = [](double z) {
    return GlTest::cutOf({squareAt(0, 0, static_cast<uint32_t>(z), 4000, kGrey)});
  };
  render::Renderer renderer;
  const render::Framebuffer target(kWidthPx, kHeightPx);
  for (const auto& cut : {at(1000), at(1000 + pixel)}) {
    renderer.show(cut);
    renderer.uploadInRenderThread({.wait = true});
    renderer.draw(view, target, magentaBehind(), {.fades = true});
  }
  renderer.draw(view, target, magentaBehind(), {.now_s = render::kFadeS / 2, .fades = true});
  ASSERT_TRUE(renderer.fading());
  Pair pair{resolved(target), {}};
  render::AmbientOcclusion().darken(target, view.fov_y_rad, render::ColorMode::kSurface);
  pair.after = resolved(target);
  EXPECT_LE(pair.largestChange(), 2);
}

TEST_F(Occlusion, touchesNoSampleOfTheBackground) {
  // A dark step about as high as wide; the surfaces that share its outline's pixels are much brighter.
  const core::View view = atCrease();
  const Pair pair = drawBoth(floorAndWall(1, 150, {5, 5, 5, 255}), view);
  int darkened = 0;
  for (uint32_t y = 0; y < kHeightPx; ++y) {
    for (uint32_t x = 0; x < kWidthPx; ++x) {
      const uint8_t *const before = pair.before.pixel(x, y), *const after = pair.after.pixel(x, y);
      EXPECT_TRUE(isMagenta(after) || !isMagenta(before));
      const auto light = [](uint8_t red) { return std::pow(red / 255.0, 2.2); };
      EXPECT_LT(light(before[0]) - light(after[0]), 0.03);
      darkened += before[1] > after[1];
    }
  }
  EXPECT_GT(darkened, 500);
}

TEST_F(Occlusion, leavesNoHaloOnAFarWallBehindABox) {
  const std::vector<Mesh> meshes{squareAt(0, 0, 0, 4000, kGrey), squareAt(1600, 1600, 1500, 800, kGrey)};
  for (const double aside : {0.0, 700.0}) {
    core::View view = lookAt({2000 + aside, 2000, 4000}, {2000, 2000, 0});
    view.width_px *= 4;
    view.height_px *= 4;
    EXPECT_EQ(drawBoth(meshes, view).largestChange(), 0);
  }
}

TEST_F(Occlusion, leavesABoxFarBeforeADarkCreaseAsItIs) {
  std::vector<Mesh> meshes = floorAndWall();
  meshes.push_back(quad({{{1600, 2400, 1400}, {2400, 2400, 1400}, {2400, 2600, 1600}, {1600, 2600, 1600}}},
                        {255, 0, 0, 255}));
  const Pair pair = drawBoth(meshes, atCrease());
  int of_box = 0;
  for (uint32_t y = 0; y < kHeightPx; ++y) {
    for (uint32_t x = 0; x < kWidthPx; ++x) {
      const uint8_t *const before = pair.before.pixel(x, y), *const after = pair.after.pixel(x, y);
      if (before[0] < 5 * before[1]) continue;
      ++of_box;
      EXPECT_EQ(before[0], after[0]) << x << ", " << y;
    }
  }
  EXPECT_GT(of_box, 500);
  EXPECT_GT(pair.largestChange(), 10);
}

TEST_F(Occlusion, darkensTheWallCloseBehindABox) {
  const std::vector<Mesh> meshes{squareAt(0, 0, 0, 4000, kGrey), squareAt(1600, 1600, 100, 800, kGrey)};
  const Pair pair = drawBoth(meshes, lookAt({2000, 2000, 4000}, {2000, 2000, 0}));
  EXPECT_GT(pair.largestChange(), 4);
  EXPECT_EQ(pair.factor(kWidthPx / 2, kHeightPx / 2), 1) << "the box";
}

TEST_F(Occlusion, changesOnlyTheLitSurfaceMode) {
  for (const render::ColorModeTraits& mode : render::colorModes()) {
    render::DrawStyle style = magentaBehind();
    style.show = mode.mode;
    const Pair pair = drawBoth(floorAndWall(), atCrease(), style);
    EXPECT_EQ(pair.before.rgba == pair.after.rgba, style.show != render::ColorMode::kSurface)
        << nameOf(style.show);
  }
}

TEST_F(Occlusion, isTheSameToTheBitOnEveryRun) {
  const Mesh sphere = makeSphere(96, 48, {.attributes = {AttributeSet::kNormal}, .bump = 0.3});
  const core::View view = lookAt({9000, 5000, 4000}, {2048, 2048, 2048});
  const Pair one = drawBoth({sphere}, view), other = drawBoth({sphere}, view);
  EXPECT_GT(one.largestChange(), 5);
  EXPECT_EQ(one.after.rgba, other.after.rgba);
}

TEST_F(Occlusion, isTheSameOfALargeModelFromAfarAndOfASmallOneCloseUp) {
  const Pair small = drawBoth(floorAndWall(1), atCrease(1)), large = drawBoth(floorAndWall(64), atCrease(64));
  EXPECT_GT(small.largestChange(), 10);
  for (uint32_t y = 0; y < kHeightPx; ++y)
    for (uint32_t x = 0; x < kWidthPx; ++x)
      EXPECT_NEAR(small.after.pixel(x, y)[1], large.after.pixel(x, y)[1], 1);
}

TEST_F(Occlusion, isIndependentOfTheSizeOfThePicture) {
  core::View twice = atCrease();
  twice.width_px *= 2;
  twice.height_px *= 2;
  const Pair small = drawBoth(floorAndWall(), atCrease()), large = drawBoth(floorAndWall(), twice);
  for (uint32_t y = 60; y < 90; ++y) EXPECT_NEAR(small.factor(100, y), large.factor(200, 2 * y + 1), 0.1);
}

TEST_F(Occlusion, treatsAllModelsOfAPictureAsOne) {
  const std::vector<Mesh> meshes = floorAndWall();
  const core::View view = atCrease();
  const render::Framebuffer target(view.width_px, view.height_px);
  render::DrawStyle style = magentaBehind();
  const auto floor = rendererOf({meshes[0]}), wall = rendererOf({meshes[1]});
  floor->draw(view, target, style);
  style.over = true;
  wall->draw(view, target, style);
  render::AmbientOcclusion().darken(target, view.fov_y_rad, style.show);
  EXPECT_EQ(resolved(target).rgba, drawBoth(meshes, view).after.rgba);
}

TEST_F(Occlusion, isIndependentOfThePreviousPicture) {
  const auto renderer = rendererOf(floorAndWall());
  render::AmbientOcclusion occlusion;
  for (const uint32_t width_px : {200u, 333u, 77u, 1u}) {
    core::View view = atCrease();
    view.width_px = width_px;
    const render::Framebuffer target(view.width_px, view.height_px);
    const Pair pair = drawBoth(floorAndWall(), view);
    for (int run = 0; run < 2; ++run) {
      renderer->draw(view, target, magentaBehind());
      EXPECT_EQ(resolved(target).rgba, pair.before.rgba);
      occlusion.darken(target, view.fov_y_rad, render::ColorMode::kSurface);
      EXPECT_EQ(resolved(target).rgba, pair.after.rgba);
      EXPECT_FALSE(glIsEnabled(GL_BLEND));
      GLboolean writes_depth = GL_FALSE;
      glGetBooleanv(GL_DEPTH_WRITEMASK, &writes_depth);
      EXPECT_TRUE(writes_depth);
    }
  }
  EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
}

}  // namespace
}  // namespace lode::test
