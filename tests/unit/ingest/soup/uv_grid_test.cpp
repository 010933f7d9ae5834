#include "server/ingest/soup/uv_grid.h"

#include <cmath>
#include <initializer_list>

#include <gtest/gtest.h>

#include "common/error.h"

namespace lode::ingest {
namespace {

UvGrid gridOf(std::initializer_list<glm::vec2> coordinates) {
  UvRange range;
  for (const glm::vec2 uv : coordinates) range.add(uv);
  return chooseUvGrid(range, "a.ply");
}

glm::dvec2 trueOf(const UvGrid& grid, glm::vec2 uv) {
  return grid.origin + glm::dvec2(grid.snap(uv)) * std::ldexp(1.0, grid.scale_exponent - 16);
}

TEST(UvGrid, isPlainWithoutCoordinates) { EXPECT_EQ(gridOf({}), UvGrid()); }

TEST(UvGrid, isPlainForCoordinatesWithinTheImage) {
  EXPECT_EQ(gridOf({{0, 0}, {1, 1}}), UvGrid());
  EXPECT_EQ(gridOf({{0.25f, 0.5f}, {0.3f, 0.5f}}), UvGrid());
}

TEST(UvGrid, snapsOneToTheLastCode) {
  EXPECT_EQ(UvGrid().snap({1, 0}), glm::u16vec2(65535, 0));
  EXPECT_EQ(UvGrid().snap({0.5f, 0x1p-16f}), glm::u16vec2(32768, 1));
}

TEST(UvGrid, keepsCoordinatesOutsideTheImageWithinAStep) {
  for (const auto& [low, high] : {std::pair{-0.25f, 0.75f},
                                  {-3.0f, 5.0f},
                                  {100.0f, 101.0f},
                                  {-1e6f, 1e6f},
                                  {0.0f, 1.00001f},
                                  {-1e-30f, 1.0f}}) {
    const UvGrid grid = gridOf({{low, 0}, {high, 0.125f}});
    const double step = std::ldexp(1.0, grid.scale_exponent - 16);
    for (const float u : {low, high, 0.5f * (low + high)})
      EXPECT_LE(glm::length(trueOf(grid, {u, 0.125f}) - glm::dvec2(u, 0.125)), 1.0001 * step) << u;
  }
}

TEST(UvGrid, isTheFinestThatHolds) {
  EXPECT_EQ(gridOf({{-0.25f, 0}, {0.75f, 1}}).scale_exponent, 0);
  EXPECT_EQ(gridOf({{0, 0}, {1.5f, 1}}).scale_exponent, 1);
  EXPECT_EQ(gridOf({{100, -3}, {100.5f, 5}}).scale_exponent, 3);
}

TEST(UvGrid, hasItsOriginOnAMultipleOfItsStep) {
  const UvGrid grid = gridOf({{-0.3f, 0.1f}, {1.9f, 0.2f}});
  const double step = std::ldexp(1.0, grid.scale_exponent - 16);
  EXPECT_EQ(std::fmod(grid.origin.x, step), 0);
  EXPECT_EQ(std::fmod(grid.origin.y, step), 0);
}

TEST(UvGrid, keepsEqualCoordinatesEqualAndWholeNumbersWhole) {
  const UvGrid grid = gridOf({{-7.3f, 0}, {12.9f, 2}});
  EXPECT_EQ(trueOf(grid, {3, 1}), glm::dvec2(3, 1));
  EXPECT_EQ(grid.snap({0.1f, 0.2f}), grid.snap({0.1f, 0.2f}));
}

TEST(UvGrid, isRefusedForAHugeRange) { EXPECT_THROW(gridOf({{0, 0}, {1e30f, 0}}), Error); }

TEST(UvGrid, isRefusedForHugeCoordinates) { EXPECT_THROW(gridOf({{1e20f, 0}, {1e20f, 1}}), Error); }

}  // namespace
}  // namespace lode::ingest
