#include "server/ingest/inspect/border_gaps.h"

#include <gtest/gtest.h>

namespace lode::ingest {
namespace {

/// A border along y at a given x, with places one apart, far from the origin.
OpenBorder column(double x, double shift_of_third = 0) {
  OpenBorder border{{}, 1};
  for (int y = 0; y < 10; ++y)
    border.places.emplace_back(5e5 + x + (y == 3 ? shift_of_third : 0), 5e6 + y, 100);
  return border;
}

TEST(BorderGaps, countPlacesThatMeet) {
  const std::vector<BorderGap> gaps = compareBorders(std::vector{column(0), column(0)});
  ASSERT_EQ(gaps.size(), 1u);
  EXPECT_EQ(gaps[0].places, 20u);
  EXPECT_EQ(gaps[0].apart, 0u);
  EXPECT_EQ(gaps[0].farthest_model, 0);
}

TEST(BorderGaps, measureTheFarthestOfThePlacesThatLieApart) {
  const std::vector<BorderGap> gaps = compareBorders(std::vector{column(0), column(0, 0.25)});
  ASSERT_EQ(gaps.size(), 1u);
  EXPECT_EQ(gaps[0].places, 20u);
  EXPECT_EQ(gaps[0].apart, 2u);
  EXPECT_EQ(gaps[0].farthest_model, 0.25);
}

TEST(BorderGaps, leaveOutFilesThatAreNoNeighbours) {
  EXPECT_TRUE(compareBorders(std::vector{column(0), column(0.6)}).empty());
  EXPECT_TRUE(compareBorders(std::vector{column(0), OpenBorder{}}).empty());
}

TEST(BorderGaps, nameEachPairOfNeighbours) {
  const std::vector<BorderGap> gaps =
      compareBorders(std::vector{column(0), column(100), column(0), column(100)});
  ASSERT_EQ(gaps.size(), 2u);
  EXPECT_EQ(gaps[0].first, 0u);
  EXPECT_EQ(gaps[0].second, 2u);
  EXPECT_EQ(gaps[1].first, 1u);
  EXPECT_EQ(gaps[1].second, 3u);
}

}  // namespace
}  // namespace lode::ingest
