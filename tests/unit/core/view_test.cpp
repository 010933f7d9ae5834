#include "client/core/view/view.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace lode::core {
namespace {

const View kView{.eye_model = {0, 0, 10},
                 .forward = {0, 0, -1},
                 .up = {0, 1, 0},
                 .fov_y_rad = 1,
                 .width_px = 800,
                 .height_px = 400};

TEST(View, projectsAnErrorByTheTextbookFormula) {
  // At distance d, the picture shows a height of 2 d tan(fov / 2).
  EXPECT_NEAR(screenErrorPx(0.1f, 10, kView), 0.1 * 400 / (2 * 10 * std::tan(0.5)), 1e-4);
}

TEST(View, clampsDistancesBelowTheNearPlane) {
  EXPECT_EQ(screenErrorPx(1, 0, kView), screenErrorPx(1, kView.near_model, kView));
  EXPECT_TRUE(std::isfinite(screenErrorPx(1e30f, 0, kView)));
}

TEST(View, projectsErrorsMonotonically) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> length(0, 100);
  for (int i = 0; i < 1000; ++i) {
    const float a = length(random), b = length(random), d = length(random);
    EXPECT_EQ(a <= b, screenErrorPx(a, d, kView) <= screenErrorPx(b, d, kView));
    EXPECT_GE(screenErrorPx(a, d, kView), screenErrorPx(a, d + 1.0, kView));
  }
}

TEST(View, measuresTheDistanceToTheNearestPointOfABox) {
  const ModelBox box{{0, 0, 0}, {2, 2, 2}};
  EXPECT_EQ(distanceToBox({1, 1, 1}, box), 0);
  EXPECT_EQ(distanceToBox({1, 1, 7}, box), 5);
  EXPECT_EQ(distanceToBox({5, 6, 1}, box), 5);
}

TEST(View, findsOnlyABoxInFrontVisible) {
  const auto boxAround = [](glm::dvec3 centre) { return ModelBox{centre - 0.5, centre + 0.5}; };
  EXPECT_TRUE(boxMayBeVisible(boxAround({0, 0, 0}), kView));
  EXPECT_TRUE(boxMayBeVisible(boxAround({0, 0, 10}), kView));
  EXPECT_FALSE(boxMayBeVisible(boxAround({0, 0, 20}), kView));
  EXPECT_FALSE(boxMayBeVisible(boxAround({0, 20, 0}), kView));
  EXPECT_FALSE(boxMayBeVisible(boxAround({0, -20, 0}), kView));
  EXPECT_FALSE(boxMayBeVisible(boxAround({20, 0, 0}), kView));
  EXPECT_FALSE(boxMayBeVisible(boxAround({-20, 0, 0}), kView));
  EXPECT_TRUE(boxMayBeVisible(boxAround({9, 0, 0}), kView));
}

TEST(View, neverCallsABoxWithAVisiblePointInvisible) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> side(0, 5), place(-1, 1);
  const double tan_y = std::tan(0.5), tan_x = tan_y * 2;
  for (int i = 0; i < 2000; ++i) {
    const double depth = 30 * std::abs(place(random)) + 1e-3;
    const glm::dvec3 point =
        kView.eye_model + glm::dvec3(place(random) * tan_x, place(random) * tan_y, -1) * depth;
    const ModelBox box{point - glm::dvec3(side(random), side(random), side(random)),
                       point + glm::dvec3(side(random), side(random), side(random))};
    EXPECT_TRUE(boxMayBeVisible(box, kView));
  }
}

TEST(View, scalesALatticeBoxByTheStep) {
  LatticeBox box;
  box.add(glm::uvec3(1, 2, 3));
  box.add(glm::uvec3(4, 5, 6));
  const ModelBox model = toModelBox(box, 0.5);
  EXPECT_EQ(model.min, glm::dvec3(0.5, 1, 1.5));
  EXPECT_EQ(model.max, glm::dvec3(2, 2.5, 3));
}

}  // namespace
}  // namespace lode::core
