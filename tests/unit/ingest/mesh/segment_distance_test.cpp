#include "server/ingest/mesh/segment_distance.h"

#include <array>
#include <random>

#include <gtest/gtest.h>

#include "common/point_segment.h"

namespace lode::ingest {
namespace {

using Pair = std::array<Segment, 2>;

FourSegments fourOf(const std::array<Pair, 4>& pairs, size_t which) {
  const auto at = [&](size_t k) { return pairs[k][which]; };
  return {FourVectors(at(0).from, at(1).from, at(2).from, at(3).from),
          FourVectors(at(0).to, at(1).to, at(2).to, at(3).to)};
}

TEST(SegmentDistance, agreesWithDensePointsOfEachPair) {
  std::mt19937 random(5);
  const auto point = [&] { return glm::vec3(random() % 64, random() % 64, random() % 8); };
  for (int i = 0; i < 500; ++i) {
    std::array<Pair, 4> pairs;
    for (Pair& pair : pairs) pair = {Segment{point(), point()}, Segment{point(), point()}};
    const Four there = squaredDistances(fourOf(pairs, 0), fourOf(pairs, 1)),
               back = squaredDistances(fourOf(pairs, 1), fourOf(pairs, 0));
    for (size_t n = 0; n < 4; ++n) {
      const auto& [p, q] = pairs[n];
      float found = squaredDistanceToSegment(p.from, q.from, q.to);
      for (int k = 1; k <= 256; ++k)
        found = std::min(found, squaredDistanceToSegment(glm::mix(p.from, p.to, static_cast<float>(k) / 256),
                                                         q.from, q.to));
      EXPECT_LE(std::sqrt(there[n]), std::sqrt(found) + 1e-3f);
      EXPECT_GE(std::sqrt(there[n]), std::sqrt(found) - 0.25f);
      EXPECT_NEAR(std::sqrt(there[n]), std::sqrt(back[n]), 1e-3f);
    }
  }
}

TEST(SegmentDistance, takesPointsAndParallelsToo) {
  const std::array<Pair, 4> pairs{Pair{Segment{{1, 2, 3}, {1, 2, 3}}, Segment{{1, 2, 7}, {1, 2, 7}}},
                                  Pair{Segment{{5, 4, 0}, {5, 4, 0}}, Segment{{0, 0, 0}, {10, 0, 0}}},
                                  Pair{Segment{{0, 0, 0}, {10, 0, 0}}, Segment{{4, 3, 0}, {20, 3, 0}}},
                                  Pair{Segment{{0, 0, 0}, {10, 0, 0}}, Segment{{13, 4, 0}, {20, 4, 0}}}};
  const Four found = squaredDistances(fourOf(pairs, 0), fourOf(pairs, 1));
  EXPECT_FLOAT_EQ(found[0], 16);
  EXPECT_FLOAT_EQ(found[1], 16);
  EXPECT_FLOAT_EQ(found[2], 9);
  EXPECT_FLOAT_EQ(found[3], 25);
}

}  // namespace
}  // namespace lode::ingest
