#include "server/ingest/mesh/segment_distance.h"

#include <random>

#include <gtest/gtest.h>

#include "common/point_segment.h"

namespace lode::ingest {
namespace {

TEST(SegmentDistance, isThatOfTheNearestOfDensePoints) {
  std::mt19937 random(5);
  const auto point = [&] { return glm::vec3(random() % 64, random() % 64, random() % 8); };
  for (int i = 0; i < 2000; ++i) {
    const Segment p{point(), point()}, q{point(), point()};
    float found = squaredDistanceToSegment(p.from, q.from, q.to);
    for (int k = 1; k <= 256; ++k)
      found = std::min(
          found, squaredDistanceToSegment(glm::mix(p.from, p.to, static_cast<float>(k) / 256), q.from, q.to));
    const float distance = std::sqrt(squaredDistance(p, q));
    EXPECT_LE(distance, std::sqrt(found) + 1e-3f);
    EXPECT_GE(distance, std::sqrt(found) - 0.25f);
    EXPECT_NEAR(distance, std::sqrt(squaredDistance(q, p)), 1e-3f);
  }
}

TEST(SegmentDistance, takesPointsAndParallelsToo) {
  EXPECT_FLOAT_EQ(squaredDistance({{1, 2, 3}, {1, 2, 3}}, {{1, 2, 7}, {1, 2, 7}}), 16);
  EXPECT_FLOAT_EQ(squaredDistance({{5, 4, 0}, {5, 4, 0}}, {{0, 0, 0}, {10, 0, 0}}), 16);
  EXPECT_FLOAT_EQ(squaredDistance({{0, 0, 0}, {10, 0, 0}}, {{4, 3, 0}, {20, 3, 0}}), 9);
  EXPECT_FLOAT_EQ(squaredDistance({{0, 0, 0}, {10, 0, 0}}, {{13, 4, 0}, {20, 4, 0}}), 25);
}

}  // namespace
}  // namespace lode::ingest
