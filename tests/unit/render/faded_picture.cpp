// Tests pictures of a fade; cross_fade.cpp tests which parts are drawn with which dither range.

#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "client/render/passes/cross_fade.h"
#include "gl_fixture.h"
#include "tests/support/test_meshes.h"

namespace lode::test {
namespace {

using core::Cut;
using render::kFadeS;

using FadedPicture = GlTest;

/// Shows squares of different colours one after another at the same place, and counts their pixels later.
struct Shares {
  int red = 0, green = 0, blue = 0, background = 0, mixed = 0;
};

Shares sharesOf(const render::Image& image) {
  Shares shares;
  for (uint32_t y = 0; y < image.height_px; ++y) {
    for (uint32_t x = 0; x < image.width_px; ++x) {
      const uint8_t* const p = image.pixel(x, y);
      if (isMagenta(p)) {
        ++shares.background;
      } else if (p[0] > 2 * (p[1] + p[2])) {
        ++shares.red;
      } else if (p[1] > 2 * (p[0] + p[2])) {
        ++shares.green;
      } else if (p[2] > 2 * (p[0] + p[1])) {
        ++shares.blue;
      } else {
        ++shares.mixed;
      }
    }
  }
  return shares;
}

class Squares {
 public:
  Squares() : target_(kWidthPx, kHeightPx) {}
  void show(glm::u8vec4 colour, double now_s, uint32_t z = 500) {
    auto cut = std::make_shared<Cut>();
    cut->parts.push_back(
        {kRootKey, 0, true, 0, std::make_shared<const Mesh>(squareAt(0, 0, z, 1000, colour))});
    alive_.push_back(cut);
    renderer.show(cut);
    renderer.uploadInRenderThread({.wait = true});
    sharesAt(now_s);
  }
  Shares sharesAt(double now_s, bool fades = true) {
    renderer.draw(lookAt({500, 500, 800}, {500, 500, 0}), target_, GlTest::magentaBehind(), {now_s, fades});
    target_.resolve();
    return sharesOf(target_.readPixels());
  }
  render::Renderer renderer{1, {.budget_bytes = 1u << 20, .spare_bytes = 0, .page_bytes = 4096}};

 private:
  std::vector<std::shared_ptr<Cut>> alive_;
  render::Framebuffer target_;
};

constexpr glm::u8vec4 kRed(255, 0, 0, 255), kGreen(0, 255, 0, 255), kBlue(0, 0, 255, 255);
constexpr int kPixels = kWidthPx * kHeightPx;

TEST_F(FadedPicture, showsOneOfTheSurfacesAtEachPixelAndNeverTheBackground) {
  Squares squares;
  squares.show(kRed, 0);
  squares.show(kGreen, 1, 400);  // behind: the depth test would reject it
  for (const double part : {0.1, 0.37, 0.5, 0.9}) {
    const Shares shares = squares.sharesAt(1 + part * kFadeS);
    EXPECT_EQ(shares.background + shares.mixed, 0) << part;
    EXPECT_NEAR(shares.green, part * kPixels, 0.03 * kPixels) << part;
    EXPECT_EQ(shares.red + shares.green, kPixels);
  }
  EXPECT_EQ(squares.sharesAt(1 + kFadeS).green, kPixels);
}

TEST_F(FadedPicture, doesNotLetDepthChooseBetweenTheSurfaces) {
  Squares behind, before;
  behind.show(kRed, 0);
  behind.show(kGreen, 1, 400);
  before.show(kRed, 0);
  before.show(kGreen, 1, 600);
  for (const double part : {0.1, 0.37, 0.5, 0.9})
    EXPECT_EQ(behind.sharesAt(1 + part * kFadeS).green, before.sharesAt(1 + part * kFadeS).green);
}

TEST_F(FadedPicture, showsThreeSurfacesInTurnWithoutTheBackground) {
  Squares squares;
  squares.show(kRed, 0);
  squares.show(kGreen, 1, 400);
  squares.show(kBlue, 1 + kFadeS / 2, 300);
  const Shares shares = squares.sharesAt(1 + kFadeS * 3 / 4);
  EXPECT_EQ(shares.red + shares.green + shares.blue, kPixels);
  EXPECT_NEAR(shares.blue, kPixels / 4, 0.03 * kPixels);
  EXPECT_NEAR(shares.green, kPixels / 2, 0.03 * kPixels);
}

TEST_F(FadedPicture, isDrawnAtOnceWithoutFading) {
  Squares squares;
  squares.show(kRed, 0);
  squares.show(kGreen, 1);
  EXPECT_TRUE(squares.renderer.fading());
  EXPECT_EQ(squares.sharesAt(1.1, false).green, kPixels);
  EXPECT_FALSE(squares.renderer.fading());
}

TEST_F(FadedPicture, keepsLeavingMeshesOnTheGpuUntilTheyHaveFaded) {
  Squares squares;
  squares.show(kRed, 0);
  squares.show(kGreen, 1);
  EXPECT_EQ(squares.renderer.meshes().meshCount(), 2u);
  squares.sharesAt(1 + kFadeS);
  squares.renderer.uploadInRenderThread({});
  EXPECT_EQ(squares.renderer.meshes().meshCount(), 1u);
}

/// A square as two instances, of which the other one stays unchanged.
TEST_F(FadedPicture, fadesAtOnePlaceOfAModelAndStaysAtAnother) {
  const auto cutOfSquare = [](glm::u8vec4 colour) {
    auto cut = std::make_shared<Cut>();
    cut->parts.push_back(
        {kRootKey, 0, true, 0, std::make_shared<const Mesh>(squareAt(0, 0, 500, 1000, colour))});
    return cut;
  };
  const auto red = cutOfSquare(kRed), green = cutOfSquare(kGreen);
  render::Renderer renderer(1);
  const render::Framebuffer target(kWidthPx, kHeightPx);
  const auto sharesAt = [&](size_t instance, double now_s) {
    renderer.drawInstance(instance, lookAt({500, 500, 800}, {500, 500, 0}), target, GlTest::magentaBehind(),
                          {now_s, true});
    renderer.drawBackground(target, GlTest::magentaBehind());
    target.resolve();
    return sharesOf(target.readPixels());
  };
  const auto show = [&](std::vector<std::shared_ptr<const Cut>> cuts) {
    renderer.show(std::make_shared<const core::ViewCuts>(core::ViewCuts{cuts, core::gatherMeshes(cuts)}));
    renderer.uploadInRenderThread({.wait = true});
  };
  show({red, red});
  for (const size_t instance : {0u, 1u}) sharesAt(instance, 0);
  show({red, green});
  for (const size_t instance : {0u, 1u}) sharesAt(instance, 1);
  EXPECT_EQ(sharesAt(0, 1 + kFadeS / 2).red, kPixels);
  EXPECT_NEAR(sharesAt(1, 1 + kFadeS / 2).green, kPixels / 2, 0.03 * kPixels);
  EXPECT_TRUE(renderer.fading());
  renderer.leaveOut(1);
  EXPECT_FALSE(renderer.fading());
  EXPECT_EQ(sharesAt(1, 1 + kFadeS / 2).green, kPixels) << "it comes into sight again";
}

/// A budget for two grids, not three.
TEST_F(FadedPicture, isAbandonedIfLeavingMeshesDoNotFit) {
  const auto cutOfGrid = [](uint32_t seed) {
    auto cut = std::make_shared<Cut>();
    cut->parts.push_back({kRootKey, 0, true, 0,
                          std::make_shared<const Mesh>(makeGrid(32, 32, {.attributes = {}, .seed = seed}))});
    return cut;
  };
  const uint32_t grid_bytes = 33 * 33 * 16 + 2 * 32 * 32 * 12;
  render::Renderer renderer(1, {.budget_bytes = 2 * grid_bytes, .page_bytes = 2 * grid_bytes});
  const render::Framebuffer target(kWidthPx, kHeightPx);
  const core::View view = lookAt({2048, 2048, 9000}, {2048, 2048, 0});
  const auto cuts = {cutOfGrid(1), cutOfGrid(2), cutOfGrid(3)};
  double now_s = 0;
  for (const auto& cut : cuts) {
    renderer.show(cut);
    renderer.uploadInRenderThread({.wait = true});
    EXPECT_TRUE(renderer.upToDate());
    renderer.draw(view, target, magentaBehind(), {now_s += 0.05, true});
    EXPECT_LE(renderer.meshes().pages().capacityBytes(), 2 * grid_bytes);
  }
  // The first was evicted for the third while it faded into the second.
  renderer.draw(view, target, magentaBehind(), {now_s + 0.05, true});
  EXPECT_FALSE(renderer.fading());
}

}  // namespace
}  // namespace lode::test
