#include <cmath>

#include <gtest/gtest.h>

#include "gl_fixture.h"
#include "tests/support/test_meshes.h"
#include "tests/unit/render/silhouette.h"

namespace lode::test {
namespace {

using Picture = GlTest;

/// Checks every pixel off the outline; at least this many must be inside.
void expectSilhouette(const render::Image& image, const Silhouette& silhouette, int least_inside) {
  int inside = 0, holes = 0, strays = 0;
  for (uint32_t y = 0; y < image.height_px; ++y) {
    for (uint32_t x = 0; x < image.width_px; ++x) {
      const int around = silhouette.around(x, y);
      if (around == 1) {
        ++inside;
        if (showsMagenta(image.pixel(x, y))) ++holes;
      } else if (around == 0 && !isMagenta(image.pixel(x, y))) {
        ++strays;
      }
    }
  }
  EXPECT_GE(inside, least_inside);
  EXPECT_EQ(holes, 0);
  EXPECT_EQ(strays, 0);
}

TEST_F(Picture, coversTheProjectionOfTheMesh) {
  const double step = 1.0 / 1024;
  const Mesh sphere = makeSphere(48, 24, {.attributes = {AttributeSet::kNormal}, .bump = 0.2});
  for (const glm::dvec3 eye : {glm::dvec3(2, 2, 9), glm::dvec3(-3, 4, 5), glm::dvec3(7.5, -1.25, 3)}) {
    const core::View view = lookAt(eye, {2, 2, 2});
    Silhouette silhouette(view);
    silhouette.add(sphere, step);
    expectSilhouette(drawMeshes({sphere}, step, view), silhouette, 2000);
  }
}

/// Makes two adjacent nodes that have only their common boundary in common.
std::vector<Mesh> neighbours(glm::uvec3 origin, uint32_t extent, uint32_t gap = 0) {
  MeshOptions left{.attributes = {}, .extent = extent, .origin = origin, .seed = 3, .bump = 0.08};
  MeshOptions right = left;
  right.origin.x += extent;
  Mesh a = makeGrid(24, 24, left), b = makeGrid(24, 24, right);
  for (glm::u32vec3& t : b.triangles) t = {t.z, t.x, t.y};
  for (PositionCode& code : b.positions) code.value += gap;
  return {a, b};
}

struct CrackCase {
  glm::uvec3 origin;
  uint32_t extent;
  double step;
  glm::dvec3 from;  ///< from the middle of the boundary to the eye, in extents
};

const glm::uvec3 kFarCorner(1'000'003, 1'040'017, 1'999'999);
const CrackCase kCrackCases[] = {
    {{0, 0, 0}, 4096, 1.0 / 4096, {0.1, -0.2, 1.5}},     {{0, 0, 0}, 4096, 1.0 / 4096, {0.9, 0.61, 0.47}},
    {kFarCorner, 4096, 1.0, {0.0317, -0.6, 0.8}},        {kFarCorner, 4096, 1.0, {-0.7, 0.313, 0.371}},
    {kFarCorner, 240, 4.0, {0.11, 0.37, 0.59}},          {kFarCorner, 240, 0.25, {-0.23, -0.11, 0.35}},
    {kFarCorner, 240, 0x1p-20, {-0.353, -0.511, 0.635}},
};

struct BorderCheck {
  int looked = 0;  ///< points checked along the boundary, off the outline
  int holes = 0;   ///< points that show the background
};

BorderCheck lookAlongBorder(const CrackCase& test, uint32_t gap) {
  const std::vector<Mesh> whole = neighbours(test.origin, test.extent);
  const glm::dvec3 middle =
      (glm::dvec3(test.origin) + glm::dvec3(test.extent, test.extent / 2.0, 0)) * test.step;
  const core::View view = lookAt(middle + test.from * (test.extent * test.step), middle);
  Silhouette silhouette(view);
  for (const Mesh& mesh : whole) silhouette.add(mesh, test.step);
  const render::Image image = GlTest::drawMeshes(neighbours(test.origin, test.extent, gap), test.step, view);
  BorderCheck check;
  for (size_t row = 0; row < 24; ++row) {
    for (int part = 0; part < 40; ++part) {
      const glm::dvec3 from(unpackPosition(whole[0].positions[row * 25 + 24]));
      const glm::dvec3 to(unpackPosition(whole[0].positions[row * 25 + 49]));
      const glm::dvec3 point = glm::mix(from, to, part / 40.0) * test.step;
      if (glm::dot(point - view.eye_model, view.forward) <= 0) continue;
      const glm::dvec2 place = projectTo(view, point);
      if (place.x < 0 || place.y < 0 || place.x >= kWidthPx || place.y >= kHeightPx) continue;
      const glm::uvec2 pixel(place);
      if (silhouette.around(pixel.x, pixel.y) != 1) continue;
      ++check.looked;
      if (showsMagenta(image.pixel(pixel.x, pixel.y))) ++check.holes;
    }
  }
  return check;
}

TEST_F(Picture, hasNoCrackAlongABorderOfTwoNodes) {
  for (const CrackCase& test : kCrackCases) {
    const std::vector<Mesh> meshes = neighbours(test.origin, test.extent);
    ASSERT_EQ(unpackPosition(meshes[0].positions[24]), unpackPosition(meshes[1].positions[0]));
    const BorderCheck check = lookAlongBorder(test, 0);
    EXPECT_EQ(check.holes, 0);
    EXPECT_GT(check.looked, 200);
  }
}

TEST_F(Picture, showsACrackBetweenSeparatedNodes) {
  for (const CrackCase& test : kCrackCases) {
    EXPECT_GT(lookAlongBorder(test, test.extent / 60).holes, 50);
  }
}

TEST_F(Picture, isTheSameWhereverTheModelLies) {
  const MeshOptions near{.attributes = {AttributeSet::kNormal}, .extent = 400, .bump = 0.2};
  MeshOptions far = near;
  far.origin = glm::uvec3(2'000'000, 1'234'567, 1'999'000);
  const glm::dvec3 eye(613.37, 411.73, 590.19), target(200, 200, 200);
  const render::Image at_origin = drawMeshes({makeSphere(32, 16, near)}, 1, lookAt(eye, target));
  const glm::dvec3 offset(far.origin);
  const render::Image far_out =
      drawMeshes({makeSphere(32, 16, far)}, 1, lookAt(eye + offset, target + offset));
  int worst = 0;
  for (size_t i = 0; i < at_origin.rgba.size(); ++i) {
    worst = std::max(worst, std::abs(int{at_origin.rgba[i]} - int{far_out.rgba[i]}));
  }
  EXPECT_LE(worst, 2);  // the eye's low part rounds differently
}

TEST_F(Picture, showsTheNearerOfTwoSurfacesInWhateverOrderTheyAreDrawn) {
  const Mesh red = squareAt(1000, 1000, 2000, 1000, {255, 0, 0, 255});
  const Mesh green = squareAt(1000, 1000, 1999, 1000, {0, 255, 0, 255});
  // The eye is so far away that 24 bits of ordinary depth could not separate the surfaces.
  const core::View front = [&] {
    core::View view = lookAt({1500, 1500, 1e6}, {1500, 1500, 0});
    view.fov_y_rad = 1e-3;
    return view;
  }();
  for (const auto& meshes : {std::vector{red, green}, std::vector{green, red}}) {
    const render::Image image = drawMeshes(meshes, 1, front);
    const uint8_t* middle = image.pixel(kWidthPx / 2, kHeightPx / 2);
    EXPECT_GT(middle[0], middle[1] + 60);
  }
}

TEST_F(Picture, isClippedNoFartherThanOneLatticeStep) {
  const Mesh red = squareAt(0, 0, 100, 2000, {255, 0, 0, 255});
  const render::Image image = drawMeshes({red}, 1, lookAt({1000, 1000, 102}, {1000, 1000, 0}));
  EXPECT_GT(image.pixel(kWidthPx / 2, kHeightPx / 2)[0], 100);
}

TEST_F(Picture, showsTheModelsColour) {
  for (const glm::u8vec4 colour : {glm::u8vec4(255, 0, 0, 255), glm::u8vec4(0, 255, 0, 255),
                                   glm::u8vec4(0, 0, 255, 255), glm::u8vec4(128, 128, 0, 255)}) {
    const Mesh square = squareAt(0, 0, 0, 1000, colour);
    const render::Image image = drawMeshes({square}, 1, lookAt({500, 500, 800}, {500, 500, 0}));
    const uint8_t* middle = image.pixel(kWidthPx / 2, kHeightPx / 2);
    for (int i = 0; i < 3; ++i) {
      if (colour[i] == 255) {
        EXPECT_GT(middle[i], 180);
      }
      if (colour[i] == 0) {
        EXPECT_LT(middle[i], 70);
      }
    }
  }
}

TEST_F(Picture, isAsBrightFromBothSides) {
  Mesh square = squareAt(0, 0, 500, 1000, {200, 200, 200, 255});
  square.attributes.bits |= AttributeSet::kNormal;
  for (auto& attributes : square.vertex_attributes) attributes.normal = encodeOctahedral({0, 0, 1});
  const auto brightness = [&](double eye_z) {
    const render::Image image = drawMeshes({square}, 1, lookAt({500, 500, eye_z}, {500, 500, 500}));
    return int{image.pixel(kWidthPx / 2, kHeightPx / 2)[1]};
  };
  EXPECT_NEAR(brightness(1500), brightness(-500), 2);
  EXPECT_GT(brightness(-500), 100);
}

TEST_F(Picture, isLitFromTheUpperLeft) {
  const Mesh sphere = makeSphere(48, 24, {.attributes = {AttributeSet::kNormal}, .bump = 0});
  const render::Image image = drawMeshes({sphere}, 1, lookAt({2048, 2048, 9000}, {2048, 2048, 2048}));
  const uint32_t x = kWidthPx / 2, y = kHeightPx / 2;
  EXPECT_GT(image.pixel(x - 20, y - 20)[1], image.pixel(x + 20, y + 20)[1] + 30);
}

/// Largest change of brightness between neighbours along the middle row of a sphere.
int roughestStep(const render::Image& image) {
  int worst = 0;
  for (uint32_t x = kWidthPx / 2 - 25; x < kWidthPx / 2 + 25; ++x) {
    const int a = image.pixel(x, kHeightPx / 2 - 7)[1], b = image.pixel(x + 1, kHeightPx / 2 - 7)[1];
    worst = std::max(worst, std::abs(a - b));
  }
  return worst;
}

TEST_F(Picture, isSmoothWithNormalsAndFacettedWithout) {
  const core::View view = lookAt({2048, 2048, 9000}, {2048, 2048, 2048});
  const Mesh smooth = makeSphere(20, 10, {.attributes = {AttributeSet::kNormal}, .bump = 0});
  const Mesh flat = makeSphere(20, 10, {.attributes = {}, .bump = 0});
  const int smooth_step = roughestStep(drawMeshes({smooth}, 1, view));
  EXPECT_LE(smooth_step, 8);
  EXPECT_GE(roughestStep(drawMeshes({flat}, 1, view)), 2 * smooth_step);
}

TEST_F(Picture, isTheSameWhicheverSideTheNormalsOfItsVerticesPointTo) {
  const core::View view = lookAt({2048, 2048, 9000}, {2048, 2048, 2048});
  const Mesh even = makeSphere(40, 20, {.attributes = {AttributeSet::kNormal}, .bump = 0});
  Mesh mixed = even;
  for (size_t i = 0; i < mixed.vertex_attributes.size(); ++i) {
    uint16_t& normal = mixed.vertex_attributes[i].normal;
    if (i * 2654435761u >> 4 & 1) normal = encodeOctahedral(-decodeOctahedral(normal));
  }
  const render::Image expected = drawMeshes({even}, 1, view), image = drawMeshes({mixed}, 1, view);
  int inside = 0, off = 0;
  for (uint32_t y = 0; y < image.height_px; ++y)
    for (uint32_t x = 0; x < image.width_px; ++x) {
      if (showsMagenta(expected.pixel(x, y))) continue;
      ++inside;
      off += std::abs(int{image.pixel(x, y)[1]} - int{expected.pixel(x, y)[1]}) > 12;
    }
  EXPECT_GT(inside, 2000);
  EXPECT_LT(off, inside / 50);
}

TEST_F(Picture, showsTheFallbackOnceALeftOutNodeIsVisible) {
  const glm::u8vec4 red(255, 0, 0, 255), green(0, 255, 0, 255);
  auto cut = std::make_shared<core::Cut>(*cutOf({squareAt(100, 100, 100, 100, red)}));
  cut->fallbacks.push_back(
      {{kRootKey, 0, false, 0, std::make_shared<const Mesh>(squareAt(100, 100, 90, 300, green))},
       0,
       1,
       0,
       1,
       0});
  cut->left_out.push_back({kRootKey.child(7), {{300, 300, 80}, {400, 400, 100}}});
  render::Renderer renderer;
  renderer.show(cut);
  renderer.uploadInRenderThread({.wait = true});
  const auto countOf = [&](const core::View& view, int channel) {
    render::DrawStyle style = magentaBehind();
    style.show = render::ColorMode::kUnlit;
    const render::Image image = draw(renderer, view, style);
    int count = 0;
    for (uint32_t y = 0; y < image.height_px; ++y)
      for (uint32_t x = 0; x < image.width_px; ++x) {
        const uint8_t* const pixel = image.pixel(x, y);
        count += pixel[channel] > 50 && pixel[1 - channel] == 0 && pixel[2] == 0;
      }
    return count;
  };
  const core::View at_part = lookAt({150, 150, 300}, {150, 150, 100}),
                   at_gap = lookAt({250, 250, 700}, {250, 250, 100});
  EXPECT_GT(countOf(at_part, 0), 1000);
  EXPECT_EQ(countOf(at_part, 1), 0);
  ASSERT_EQ(renderer.inPicture().size(), 1u);
  EXPECT_EQ(renderer.inPicture()[0].node, cut->parts[0].node);
  EXPECT_GT(countOf(at_gap, 1), 1000);
  EXPECT_EQ(countOf(at_gap, 0), 0);
  ASSERT_EQ(renderer.inPicture().size(), 1u);
  EXPECT_EQ(renderer.inPicture()[0].node, kRootKey);
}

TEST_F(Picture, reportsTheThresholdsOfShownAndWantedParts) {
  const glm::u8vec4 red(255, 0, 0, 255);
  auto cut = std::make_shared<core::Cut>(
      *cutOf({squareAt(100, 100, 100, 100, red), squareAt(200, 100, 100, 100, red),
              squareAt(9000, 0, 100, 1, red)}));
  cut->view.height_px = kHeightPx;
  cut->threshold_px = 2;
  cut->parts[0].threshold_px = 2;
  cut->parts[1].threshold_px = 8;    // a coarser stand-in
  cut->parts[2].threshold_px = 100;  // outside the view
  render::Renderer renderer;
  renderer.show(cut);
  renderer.uploadInRenderThread({.wait = true});
  const render::Framebuffer target(kWidthPx, kHeightPx);
  const render::ShownThresholds shown = renderer.draw(lookAt({200, 150, 500}, {200, 150, 100}), target).shown;
  EXPECT_NEAR(shown.drawn.px(), 2, 1e-6);
  render::MeanThreshold mean;
  mean.add(1, 2);
  mean.add(1, 8);
  EXPECT_NEAR(shown.complete.px(), mean.px(), 1e-6);
}

TEST_F(Picture, reportsThresholdsAndErrorsInItsOwnPixels) {
  auto cut = std::make_shared<core::Cut>(*cutOf({squareAt(100, 100, 100, 100, {255, 0, 0, 255})}));
  cut->view.height_px = 2 * kHeightPx;
  cut->threshold_px = cut->parts[0].threshold_px = 8;
  cut->parts[0].error_px = 6;
  render::Renderer renderer;
  renderer.show(cut);
  renderer.uploadInRenderThread({.wait = true});
  const render::Framebuffer target(kWidthPx, kHeightPx);
  const render::DrawCounts drawn = renderer.draw(lookAt({150, 150, 500}, {150, 150, 100}), target);
  EXPECT_NEAR(drawn.shown.drawn.px(), 4, 1e-6);
  EXPECT_NEAR(drawn.shown.complete.px(), 4, 1e-6);
  EXPECT_NEAR(drawn.error_px, 3, 1e-6);
}

TEST_F(Picture, isTheBackgroundForAnEmptyCut) {
  const render::Image image = drawMeshes({}, 1, lookAt({0, 0, 10}, {0, 0, 0}));
  EXPECT_TRUE(isMagenta(image.pixel(0, 0)));
  EXPECT_TRUE(isMagenta(image.pixel(kWidthPx / 2, kHeightPx / 2)));
}

TEST_F(Picture, isRefusedInASizeThatTheDriverCannotMake) {
  EXPECT_THROW(render::Framebuffer(1u << 30, 16), Error);
  EXPECT_THROW(render::Framebuffer(0, 16), Error);
}

}  // namespace
}  // namespace lode::test
