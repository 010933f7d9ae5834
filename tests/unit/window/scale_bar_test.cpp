#include "client/app/window/panel/scale_bar.h"

#include <cmath>

#include <gtest/gtest.h>

#include "client/app/window/panel/projection.h"

namespace lode::app {
namespace {

core::View scaledView() {
  core::View view;
  view.eye_model = {0, 0, 10};
  view.width_px = 800;
  view.height_px = 600;
  return view;
}

TEST(ScaleBar, isAsLongAsItsLengthAtTheDistance) {
  const core::View view = scaledView();
  const auto bar = scaleBarOf(view, 10, 150, "mm");
  ASSERT_TRUE(bar);
  EXPECT_EQ(bar->text, "2 mm");
  EXPECT_NEAR(bar->length_px,
              glm::distance(*pointInPicture(view, {0, 0, 0}), *pointInPicture(view, {2, 0, 0})), 1e-9);
}

TEST(ScaleBar, isAOneATwoOrAFiveAndAtLeastTwoFifthsOfTheRoom) {
  for (double distance = 1e-7; distance < 1e9; distance *= 1.37) {
    const auto bar = scaleBarOf(scaledView(), distance, 150, "");
    ASSERT_TRUE(bar);
    EXPECT_TRUE(bar->length_px <= 150 * (1 + 1e-9) && bar->length_px > 59) << bar->length_px;
    const double first =
        std::stod(bar->text) / std::pow(10, std::floor(std::log10(std::stod(bar->text)) + 1e-9));
    EXPECT_LT(std::min({std::abs(first - 1), std::abs(first - 2), std::abs(first - 5)}), 1e-6) << bar->text;
  }
  EXPECT_FALSE(scaleBarOf(scaledView(), 0, 150, ""));
}

TEST(ScaleBar, hasAxesAsThePictureShowsThem) {
  const auto axes = axesInPicture(scaledView());
  EXPECT_EQ(axes[0], glm::dvec3(1, 0, 0));
  EXPECT_EQ(axes[1], glm::dvec3(0, -1, 0)) << "upwards";
  EXPECT_EQ(axes[2], glm::dvec3(0, 0, -1)) << "towards the viewer";
}

}  // namespace
}  // namespace lode::app
