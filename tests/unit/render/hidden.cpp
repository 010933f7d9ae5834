#include <cmath>

#include <gtest/gtest.h>

#include "client/core/lod/triangle_clusters.h"
#include "client/render/culling/depth_pyramid.h"
#include "gl_fixture.h"
#include "tests/support/test_meshes.h"

namespace lode::test {
namespace {

using render::OcclusionCulling;

using Hidden = GlTest;
class HiddenBy : public GlTest, public ::testing::WithParamInterface<OcclusionCulling> {
 protected:
  void SetUp() override {
    GlTest::SetUp();
    if (!IsSkipped() && GetParam() == OcclusionCulling::kOnGpu && !render::GpuCulling::isPossible())
      GTEST_SKIP() << "this driver does not count draws";
  }
  void TearDown() override { EXPECT_TRUE(IsSkipped() || glGetError() == GL_NO_ERROR); }
};
INSTANTIATE_TEST_SUITE_P(All, HiddenBy,
                         ::testing::Values(OcclusionCulling::kReadBack, OcclusionCulling::kOnGpu),
                         [](const auto& way) {
                           return way.param == OcclusionCulling::kReadBack ? "reading" : "theGpu";
                         });

std::shared_ptr<const Mesh> clustered(Mesh mesh) {
  core::clusterTriangles(mesh);
  return std::make_shared<const Mesh>(std::move(mesh));
}

std::shared_ptr<const Mesh> sphereAt(glm::uvec3 origin, uint32_t seed, uint32_t slices) {
  return clustered(
      makeSphere(slices, slices / 2,
                 {.attributes = {AttributeSet::kNormal}, .origin = origin, .seed = seed, .bump = 0.1}));
}

std::shared_ptr<const Mesh> plainAt(glm::uvec3 origin, uint32_t seed) {
  return clustered(makeGrid(
      80, 80, {.attributes = {AttributeSet::kNormal}, .extent = 8000, .origin = origin, .seed = seed}));
}

/// Two closed models that hide each other by turns, over an open one.
std::shared_ptr<const core::Cut> scene(uint32_t seed = 1, uint32_t slices = 96) {
  return GlTest::cutOf(std::vector{sphereAt({1000, 1000, 2500}, seed, slices),
                                   sphereAt({4500, 2000, 3000}, seed + 1, slices),
                                   plainAt({500, 500, 500}, seed + 2)});
}

/// A camera that moves around, sometimes below the plain or inside a sphere.
core::View viewAt(int frame) {
  const double angle = 0.2 * frame;
  const glm::dvec3 middle(4500, 4000, 3500);
  const double away = frame % 37 == 36 ? 2000 : 9000;
  const glm::dvec3 aside(std::cos(angle), std::sin(angle), 0.6 * std::sin(0.37 * angle));
  core::View view = lookAt(middle + away * aside, middle, {0, 0, 1});
  view.width_px *= 3;
  view.height_px *= 3;
  return view;
}

/// Draws with two renderers: everything, and with occlusion culling.
class TwoWays {
 public:
  explicit TwoWays(OcclusionCulling way, int samples = 4) : way_(way), samples_(samples) {}

  void show(const std::shared_ptr<const core::Cut>& cut) {
    for (render::Renderer* const renderer : {&all_, &seen_}) {
      renderer->show(cut);
      renderer->uploadInRenderThread({.wait = true});
    }
  }
  void expectSamePicture(const core::View& view, const render::DrawStyle& style = {}, double now_s = 0,
                         bool fades = false) {
    const render::Framebuffer target(view.width_px, view.height_px, samples_);
    all_triangles = all_.draw(view, target, style, {now_s, fades, OcclusionCulling::kOff}).triangles;
    target.resolve();
    const render::Image all = target.readPixels();
    seen_triangles = seen_.draw(view, target, style, {now_s, fades, way_}).triangles;
    target.resolve();
    EXPECT_EQ(target.readPixels().rgba, all.rgba);
  }
  bool fading() const { return seen_.fading(); }

  uint64_t all_triangles = 0, seen_triangles = 0;

 private:
  const OcclusionCulling way_;
  const int samples_;
  render::Renderer all_, seen_;
};

TEST_P(HiddenBy, isLeftOutAndThePictureIsTheSameToTheBit) {
  for (const int samples : {4, 1}) {
    TwoWays ways(GetParam(), samples);
    ways.show(scene());
    uint64_t all = 0, seen = 0;
    for (int frame = 0; frame < 40; ++frame) {
      ways.expectSamePicture(viewAt(frame));
      all += ways.all_triangles;
      seen += ways.seen_triangles;
    }
    EXPECT_LT(seen, 0.95 * static_cast<double>(all)) << samples << " samples";
  }
}

TEST_P(HiddenBy, showsAtOnceWhenTheCameraJumps) {
  TwoWays ways(GetParam());
  ways.show(scene());
  for (const int frame : {0, 0, 29, 3, 29, 50, 0}) ways.expectSamePicture(viewAt(frame));
}

/// The section plane moves in every second frame. It uncovers surfaces that were hidden by the half it
/// removes.
TEST_P(HiddenBy, showsWhatASectionUncovers) {
  TwoWays ways(GetParam());
  ways.show(scene());
  uint64_t all = 0, seen = 0;
  for (int frame = 0; frame < 40; ++frame) {
    render::DrawStyle style;
    glm::dvec3 normal(0);
    normal[frame / 10 % 3] = frame % 4 < 2 ? 1 : -1;
    style.section = render::Section{normal, (2500 + 50 * (frame / 2)) * normal[frame / 10 % 3], {0, 0, 1}};
    ways.expectSamePicture(viewAt(frame / 3), style);
    all += ways.all_triangles;
    seen += ways.seen_triangles;
  }
  EXPECT_LT(seen, all);
}

TEST_P(HiddenBy, isNotDrawnAgainWhileTheCameraRests) {
  TwoWays ways(GetParam());
  ways.show(scene(1, 192));
  std::vector<uint64_t> told;
  for (int frame = 0; frame < 8; ++frame) {
    ways.expectSamePicture(viewAt(0));
    told.push_back(ways.seen_triangles);
  }
  const size_t first = GetParam() == OcclusionCulling::kOnGpu ? 3 : 0;  // counts of the GPU arrive later
  EXPECT_EQ(told[first], ways.all_triangles);  // nothing is hidden in the first frame
  EXPECT_LT(told[first + 1], 0.8 * static_cast<double>(ways.all_triangles));
  EXPECT_EQ(told[first + 2], told[first + 1]);
}

TEST_P(HiddenBy, isNotDeterminedByAPictureOfAnotherSize) {
  TwoWays ways(GetParam());
  ways.show(scene());
  for (const uint32_t size_px : {600u, 150u, 31u, 1u, 450u}) {
    for (const int frame : {0, 29}) {
      core::View view = viewAt(frame);
      view.width_px = size_px;
      view.height_px = (size_px * 3 + 3) / 4;
      ways.expectSamePicture(view);
    }
  }
}

TEST_P(HiddenBy, changesNoViewOfTheModel) {
  TwoWays ways(GetParam());
  ways.show(scene());
  for (const render::ColorMode show :
       {render::ColorMode::kUnlit, render::ColorMode::kWireframe, render::ColorMode::kNodes,
        render::ColorMode::kNormals, render::ColorMode::kErrors}) {
    for (int frame = 0; frame < 3; ++frame) ways.expectSamePicture(viewAt(frame), {.show = show});
  }
}

TEST_P(HiddenBy, changesNoFade) {
  TwoWays ways(GetParam());
  ways.show(scene(1));
  ways.expectSamePicture(viewAt(0), {}, 0, true);
  ways.show(scene(11));
  int fading = 0;
  for (int frame = 0; frame < 12; ++frame) {
    ways.expectSamePicture(viewAt(frame), {}, 1 + 0.03 * frame, true);
    fading += ways.fading();
  }
  EXPECT_GT(fading, 5);
}

TEST_P(HiddenBy, showsAReturningPartAtOnce) {
  TwoWays ways(GetParam());
  const auto cut = scene(1), other = scene(11);
  ways.show(cut);
  for (int frame = 0; frame < 2; ++frame) ways.expectSamePicture(viewAt(0), {}, 0, true);
  ways.show(other);
  ways.expectSamePicture(viewAt(0), {}, 1, true);
  ways.expectSamePicture(viewAt(0), {}, 1 + render::kFadeS / 4, true);
  ways.show(cut);
  double now_s = 1 + render::kFadeS / 2;
  for (const int frame : {0, 0, 29, 3})
    ways.expectSamePicture(viewAt(frame), {}, now_s += render::kFadeS / 16, true);
  EXPECT_TRUE(ways.fading());
}

/// Two instances of a model, one behind the other for most cameras.
class TwoPlaces {
 public:
  TwoPlaces(const std::shared_ptr<const core::Cut>& cut, OcclusionCulling way) : way_(way) {
    const std::vector cuts{cut, cut};
    renderer_.show(std::make_shared<const core::ViewCuts>(core::ViewCuts{cuts, core::gatherMeshes(cuts)}));
    renderer_.uploadInRenderThread({.wait = true});
  }
  /// @return triangles drawn.
  uint64_t draw(const core::View& view, const render::Framebuffer& target, bool is_second_there = true) {
    core::View shifted = view;
    shifted.eye_model += glm::dvec3(0, 12'000, 0);
    std::vector<render::InstanceDraw> draws{{&renderer_, 0, view, {}}};
    if (is_second_there)
      draws.push_back({&renderer_, 1, shifted, {.over = true}});
    else
      renderer_.leaveOut(1);
    const render::DrawCounts counts = drawer_.draw(draws, target, {.occlusion_culling = way_});
    renderer_.drawBackground(target, {});
    return counts.triangles;
  }

 private:
  const OcclusionCulling way_;
  render::Renderer renderer_;
  render::InstanceDrawer drawer_;
};

TEST_P(HiddenBy, isLeftOutBehindOtherInstances) {
  TwoPlaces all(scene(), OcclusionCulling::kOff), seen(scene(), GetParam());
  for (const int frame : {24, 8, 23, 9, 0}) {
    const core::View view = viewAt(frame);
    const render::Framebuffer target(view.width_px, view.height_px);
    const auto expectSamePicture = [&] {
      const uint64_t all_triangles = all.draw(view, target);
      target.resolve();
      const render::Image picture = target.readPixels();
      const uint64_t seen_triangles = seen.draw(view, target);
      target.resolve();
      EXPECT_EQ(target.readPixels().rgba, picture.rgba) << frame;
      return static_cast<double>(seen_triangles) / static_cast<double>(all_triangles);
    };
    double at_rest = 0;
    for (int again = 0; again < 5; ++again) at_rest = expectSamePicture();
    if (frame == 8) {  // one instance is in front of the other
      EXPECT_LT(at_rest, 0.75);
      EXPECT_GT(at_rest, 0);
    }
  }
}

TEST_P(HiddenBy, showsAReturningInstanceAtOnce) {
  TwoPlaces all(scene(), OcclusionCulling::kOff), seen(scene(), GetParam());
  for (const int frame : {8, 8, 8, 23, 24}) {
    const core::View view = viewAt(frame);
    const render::Framebuffer target(view.width_px, view.height_px);
    for (const bool is_second_there : {true, false, true}) {
      all.draw(view, target, is_second_there);
      target.resolve();
      const render::Image picture = target.readPixels();
      seen.draw(view, target, is_second_there);
      target.resolve();
      EXPECT_EQ(target.readPixels().rgba, picture.rgba) << frame;
    }
  }
}

TEST_F(Hidden, isDeterminedByTheFarthestSampleOfEachSquare) {
  const core::View view = lookAt({1500, 1500, 3000}, {1500, 1500, 1000});
  render::Renderer renderer;
  renderer.show(cutOf(std::vector{squareAt(1500, 0, 1000, 4000, {255, 0, 0, 255})}));
  renderer.uploadInRenderThread({.wait = true});
  const render::Framebuffer target(kWidthPx, kHeightPx);
  renderer.draw(view, target);
  render::DepthReader reader;
  const render::FarthestDepths depths = reader.read(target);
  ASSERT_EQ(depths.columns, kWidthPx / 8);
  ASSERT_EQ(depths.rows, (kHeightPx + 7) / 8);
  const float wall = 1.0f / 2000;
  for (uint32_t row = 0; row < depths.rows; ++row) {
    for (uint32_t column = 0; column < depths.columns; ++column) {
      // The wall begins in the middle of the picture, within the 13th square from the left.
      const float depth = depths.depths[size_t{row} * depths.columns + column];
      if (column <= kWidthPx / 16)
        EXPECT_EQ(depth, 0);
      else
        EXPECT_NEAR(depth, wall, wall * 1e-5);
    }
  }
}

TEST_F(Hidden, isDeterminedByAllSamplesOfAPixel) {
  const core::View view = lookAt({1500, 1500, 3000}, {1500, 1500, 1000});
  const render::Framebuffer target(kWidthPx, kHeightPx);
  render::DepthReader reader;
  int partly = 0;
  for (uint32_t x = 1500; x < 1600; x += 2) {
    render::Renderer renderer;
    renderer.show(cutOf(std::vector{squareAt(x, 0, 1000, 4000, {255, 0, 0, 255})}));
    renderer.uploadInRenderThread({.wait = true});
    render::DrawStyle style = magentaBehind();
    style.show = render::ColorMode::kUnlit;
    renderer.draw(view, target, style);
    target.resolve();
    const render::Image picture = target.readPixels();
    const render::FarthestDepths depths = reader.read(target);
    for (uint32_t column = kWidthPx / 16; column < kWidthPx / 8; ++column) {
      // The last pixels of the left square are the first pixels that show the wall.
      const uint8_t* const first = picture.pixel(8 * column, kHeightPx / 2);
      const bool shows_background = first[2] > 0;
      partly += shows_background && first[2] < 255;
      EXPECT_EQ(depths.depths[kHeightPx / 16 * depths.columns + column] == 0, shows_background)
          << x << ", " << column;
    }
  }
  EXPECT_GT(partly, 0);
}

}  // namespace
}  // namespace lode::test
