#include "client/render/culling/occluders.h"

#include <gtest/gtest.h>

#include "gl_fixture.h"

namespace lode::test {
namespace {

using render::FarthestDepths;
using render::Occluders;

// Looks along -z; a pixel is 1 wide at distance 1000.
const core::View kTowardsWall = [] {
  core::View view = lookAt({0, 0, 1000}, {0, 0, 0});
  view.fov_y_rad = 2 * std::atan(kHeightPx / 2000.0);
  view.near_model = 1;
  return view;
}();

/// A wall at z = 0 that fills the picture.
const FarthestDepths kWall = [] {
  FarthestDepths depths{kWidthPx / 8, (kHeightPx + 7) / 8, {}};
  depths.depths.assign(size_t{depths.columns} * depths.rows, 1.0f / 1000);
  return depths;
}();

core::ModelBox boxAt(glm::dvec3 middle, double half = 5) { return {middle - half, middle + half}; }

TEST(Occluders, hideBoxesBehindThem) {
  const Occluders occluders(kTowardsWall, 1, kWall);
  EXPECT_TRUE(occluders.hide(boxAt({0, 0, -6})));
  EXPECT_TRUE(occluders.hide(boxAt({-60, 40, -500}, 100)));
}

TEST(Occluders, doNotHideBoxesThatReachBeforeThem) {
  const Occluders occluders(kTowardsWall, 1, kWall);
  EXPECT_FALSE(occluders.hide(boxAt({0, 0, 6})));
  EXPECT_FALSE(occluders.hide(boxAt({0, 0, -4})));
  EXPECT_FALSE(occluders.hide(boxAt({0, 0, -5})));  // the box touches the wall
}

TEST(Occluders, doNotHideBoxesThatReachPastTheNearPlaneOrTheEye) {
  const Occluders occluders(kTowardsWall, 1, kWall);
  EXPECT_FALSE(occluders.hide(boxAt({0, 0, 1000}, 4)));
  EXPECT_FALSE(occluders.hide(boxAt({0, 0, 0}, 2000)));
}

TEST(Occluders, doNotHideBoxesVisibleThroughOneSquare) {
  FarthestDepths holed = kWall;
  // Square 3 from the left, 5 from the bottom.
  holed.depths[size_t{5} * holed.columns + 3] = 0;
  const Occluders occluders(kTowardsWall, 1, holed);
  const glm::dvec2 lower_left(-100, -75);
  const auto at = [&](double x, double y) {  // Returns a box at a position on the wall, in pixels.
    return boxAt({lower_left.x + x, lower_left.y + y, -0.6}, 0.5);
  };
  EXPECT_FALSE(occluders.hide(at(3.5 * 8, 5.5 * 8)));
  EXPECT_FALSE(occluders.hide(at(3 * 8 - 1, 5.5 * 8)));  // the edge of the hole
  EXPECT_FALSE(occluders.hide(at(3.5 * 8, 6 * 8 + 1)));
  EXPECT_TRUE(occluders.hide(at(2.5 * 8, 5.5 * 8)));
  EXPECT_TRUE(occluders.hide(at(3.5 * 8, 7.5 * 8)));
  EXPECT_FALSE(occluders.hide(boxAt({-70, -30, -50}, 40)));  // a box around the hole
}

TEST(Occluders, doNotHideBoxesBeforeTheBackground) {
  FarthestDepths empty = kWall;
  std::ranges::fill(empty.depths, 0.0f);
  EXPECT_FALSE(Occluders(kTowardsWall, 1, empty).hide(boxAt({0, 0, -1e6})));
}

}  // namespace
}  // namespace lode::test
