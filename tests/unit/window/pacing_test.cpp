#include "client/app/window/pacing.h"

#include <gtest/gtest.h>

namespace lode::app {
namespace {

using namespace std::chrono_literals;

constexpr Pacing::Options kCoarseFirst{.begin = FrameRateControl::Begin::kCoarse};
const Pacing::TimePoint kBegun{};

/// Frames of a camera that stops.
void rest(Pacing& pacing) { pacing.step(1, false, kBegun); }

TEST(Pacing, requestsTheUsersThresholdAtRestAndCoarserCutsInMotion) {
  Pacing pacing(kCoarseFirst, kBegun);
  rest(pacing);
  EXPECT_EQ(pacing.askedPx(), 1);
  EXPECT_TRUE(pacing.asksForFinest());
  pacing.step(0.016, true, kBegun);
  EXPECT_EQ(pacing.askedPx(), 8);
  EXPECT_FALSE(pacing.asksForFinest());
  EXPECT_GT(pacing.targetMs(), 0);
}

TEST(Pacing, movesFromTheCamerasMotionUntilItsRestAndNotAtTheStart) {
  const Pacing::TimePoint start{};
  Pacing pacing({.threshold_px = 1, .begin = FrameRateControl::Begin::kCoarse}, start);
  pacing.step(0.01, false, start);
  EXPECT_FALSE(pacing.isResting()) << "the first pictures are coarse";
  EXPECT_FALSE(pacing.isMoving());
  pacing.step(0.01, true, start);
  EXPECT_TRUE(pacing.isMoving());
  pacing.step(0.01, false, start);
  EXPECT_TRUE(pacing.isMoving());
  pacing.step(10, false, start);
  EXPECT_FALSE(pacing.isMoving());
}

TEST(Pacing, requestsAFixedThresholdWhateverTheFrameTime) {
  Pacing pacing({.threshold_px = 2, .is_fixed = true, .begin = FrameRateControl::Begin::kCoarse}, kBegun);
  for (int i = 0; i < 10; ++i) {
    pacing.step(0.016, true, kBegun);
    pacing.measure(800, render::Coarsening{1, 1});
  }
  EXPECT_EQ(pacing.askedPx(), 2);
  EXPECT_EQ(pacing.targetMs(), 0);
  EXPECT_FALSE(pacing.isWorthWaiting(1, false, kBegun));
}

TEST(Pacing, acceptsChangesOfRateAndFixedThresholdWhileRunning) {
  Pacing pacing(kCoarseFirst, kBegun);
  pacing.step(0.016, true, kBegun);
  EXPECT_NEAR(pacing.targetMs(), 1000.0 / 60, 1e-9);
  pacing.setRate(20);
  EXPECT_EQ(pacing.fps(), 20);
  EXPECT_NEAR(pacing.targetMs(), 50, 1e-9);
  pacing.setThreshold(3);
  pacing.fix(true);
  pacing.step(0.016, true, kBegun);
  EXPECT_EQ(pacing.askedPx(), 3);
  EXPECT_EQ(pacing.targetMs(), 0);
  pacing.fix(false);
  pacing.step(0.016, true, kBegun);
  EXPECT_GT(pacing.askedPx(), 3);
  pacing.setThreshold(1e9f);
  EXPECT_EQ(pacing.thresholdPx(), kLargestThresholdPx);
}

TEST(Pacing, ignoresEmptyFrames) {
  Pacing pacing({}, kBegun);
  for (int i = 0; i < 10; ++i) pacing.measure(800, std::nullopt);
  pacing.step(0.016, true, kBegun);
  EXPECT_EQ(pacing.askedPx(), 1);
  for (int i = 0; i < 10; ++i) pacing.measure(800, render::Coarsening{1, 1});
  pacing.step(0.016, true, kBegun);
  EXPECT_GT(pacing.askedPx(), 1);
}

TEST(Pacing, keepsThresholdsWithinTheirBounds) {
  Pacing pacing(kCoarseFirst, kBegun);
  pacing.sharpen(-16);
  EXPECT_NEAR(pacing.thresholdPx(), 16, 1e-3);
  pacing.step(0.016, true, kBegun);
  EXPECT_NEAR(pacing.askedPx(), kLargestThresholdPx, 1e-3);
  pacing.sharpen(-100);
  EXPECT_EQ(pacing.thresholdPx(), kLargestThresholdPx);
  pacing.sharpen(100);
  EXPECT_EQ(pacing.thresholdPx(), kLeastThresholdPx);
}

TEST(Pacing, keepsAnOutOfRangeThresholdUntilAKeyIsPressed) {
  Pacing pacing({.threshold_px = 0.05f}, kBegun);
  pacing.sharpen(0);
  EXPECT_EQ(pacing.thresholdPx(), 0.05f);
  pacing.sharpen(1);
  EXPECT_EQ(pacing.thresholdPx(), kLeastThresholdPx);
}

TEST(Pacing, waitsForTheCoarserCutFromWhenTheCameraBeginsToMove) {
  Pacing pacing(kCoarseFirst, kBegun);
  pacing.measure(800, render::Coarsening{1, 1});
  pacing.draw(render::Coarsening{1, 1}, kBegun);
  rest(pacing);
  EXPECT_FALSE(pacing.isWorthWaiting(1, false, kBegun + 1s));
  const Pacing::TimePoint begun = kBegun + 10s;
  pacing.step(0.016, true, begun);
  EXPECT_TRUE(pacing.isWorthWaiting(1, true, begun));
  EXPECT_TRUE(pacing.isWorthWaiting(1, true, begun + 200ms));
  EXPECT_FALSE(pacing.isWorthWaiting(1, true, begun + 300ms));
  EXPECT_TRUE(pacing.isWorthWaiting(8, false, begun)) << "its parts are not uploaded yet";
  EXPECT_FALSE(pacing.isWorthWaiting(8, true, begun)) << "it is there";
}

/// Frames of a machine that draws pixels slowly, with the requested threshold and scale.
void flyOverPixels(Pacing& pacing) {
  for (int i = 0; i < 20; ++i) {
    pacing.step(0.016, true, kBegun);
    const double coarsening = pacing.askedPx() / pacing.thresholdPx();
    pacing.measure(30 * pacing.scale() * pacing.scale(),
                   render::Coarsening{coarsening, coarsening, 0.95, pacing.scale()});
  }
}

TEST(Pacing, requestsFewerPixelsInMotionIfPixelsAreSlow) {
  Pacing pacing({}, kBegun);
  flyOverPixels(pacing);
  EXPECT_EQ(pacing.scale(), 0.5);
  EXPECT_FALSE(pacing.asksForFinest());
  rest(pacing);
  EXPECT_EQ(pacing.scale(), 1);
  EXPECT_TRUE(pacing.asksForFinest());
}

TEST(Pacing, requestsAllPixelsIfTheThresholdIsFixed) {
  Pacing pacing({.is_fixed = true}, kBegun);
  flyOverPixels(pacing);
  EXPECT_EQ(pacing.scale(), 1);
}

}  // namespace
}  // namespace lode::app
