#include "client/render/draw_counts.h"

#include <cmath>

#include <gtest/gtest.h>

namespace lode::render {
namespace {

TEST(MeanThreshold, isTheThresholdOfItsPartsIfTheyAgree) {
  MeanThreshold mean;
  mean.add(10, 8);
  mean.add(1000, 8);
  EXPECT_NEAR(mean.px(), 8, 1e-9);
}

TEST(MeanThreshold, isTheUniformThresholdWithTheSameWork) {
  MeanThreshold half_coarse;  // a quarter of the surface at 4 pixels, three quarters at 1
  half_coarse.add(25, 4);
  half_coarse.add(600, 1);
  const double at_one_px = 25 * std::pow(4, kFallOfWork) + 600;
  EXPECT_NEAR(25 + 600, at_one_px * std::pow(half_coarse.px(), -kFallOfWork), 1e-9);
}

TEST(MeanThreshold, countsPartsOfSeveralPlacesTogether) {
  MeanThreshold one, other, both;
  one.add(10, 2);
  other.add(30, 5);
  both.add(10, 2);
  both.add(30, 5);
  EXPECT_EQ((one += other).px(), both.px());
}

TEST(Coarsening, isRelativeToTheFinestThreshold) {
  ShownThresholds shown;
  shown.drawn.add(10, 6);
  shown.complete.add(10, 12);
  const auto coarsening = coarseningOf(shown, 2);
  ASSERT_TRUE(coarsening);
  EXPECT_NEAR(coarsening->drawn, 3, 1e-9);
  EXPECT_NEAR(coarsening->complete, 6, 1e-9);
}

TEST(Coarsening, isAtLeastOne) {
  ShownThresholds shown;
  shown.drawn.add(10, 0.5);
  shown.complete.add(10, 0.5);
  EXPECT_EQ(coarseningOf(shown, 2)->drawn, 1);
  EXPECT_EQ(coarseningOf(shown, 2)->complete, 1);
}

TEST(Coarsening, isUnknownForAnEmptyPicture) { EXPECT_FALSE(coarseningOf({}, 1)); }

}  // namespace
}  // namespace lode::render
