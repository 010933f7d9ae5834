#include "server/ingest/mesh/four_triangles.h"

#include <array>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace lode::ingest {
namespace {

class RandomPlaces {
 public:
  /// Returns a point from few possible values, so that triangles are often degenerate and points often lie on
  /// corners and edges.
  glm::vec3 few() { return {number() % 4, number() % 4, number() % 4}; }
  glm::vec3 many() { return {number() % 1000, number() % 1000, number() % 1000}; }

 private:
  uint32_t number() { return static_cast<uint32_t>(random_()); }

  std::mt19937 random_{11};
};

struct Triangle {
  glm::vec3 a, b, c;

  TriangleSides sides() const { return {b - a, c - a}; }
  PackedTriangle packed() const { return {a, sides()}; }
};

/// Returns a triangle with three different corners.
template <typename Place>
Triangle triangleOf(Place&& place) {
  Triangle t{place(), place(), place()};
  while (t.b == t.a) t.b = place();
  while (t.c == t.a || t.c == t.b) t.c = place();
  return t;
}

template <typename Place>
void expectTheSameFromFourAsFromOne(Place&& place) {
  for (int i = 0; i < 20000; ++i) {
    std::array<Triangle, 4> t;
    std::array<glm::vec3, 4> at;
    for (size_t k = 0; k < 4; ++k) {
      t[k] = triangleOf(place);
      at[k] = place();
    }
    const FourVectors points(at[0], at[1], at[2], at[3]);
    const Four found =
        FourTriangles(t[0].packed(), t[1].packed(), t[2].packed(), t[3].packed()).squaredDistances(points);
    const Four by_corners = FourTriangles({t[0].a, t[1].a, t[2].a, t[3].a}, {t[0].b, t[1].b, t[2].b, t[3].b},
                                          {t[0].c, t[1].c, t[2].c, t[3].c})
                                .squaredDistances(points);
    for (size_t k = 0; k < 4; ++k) {
      const float expected = squaredDistanceToTriangle(at[k] - t[k].a, t[k].sides());
      ASSERT_EQ(found[k], expected);
      ASSERT_EQ(by_corners[k], expected);
      ASSERT_EQ(t[k].packed().squaredDistance(at[k]), expected);
    }
  }
}

TEST(FourTriangles, haveExactlyTheDistancesOfEachAlone) {
  RandomPlaces places;
  expectTheSameFromFourAsFromOne([&] { return places.many(); });
  expectTheSameFromFourAsFromOne([&] { return places.few(); });
}

TEST(FourTriangles, giveHeightsOnlyForPointsAboveTheirInterior) {
  RandomPlaces places;
  for (int i = 0; i < 20000; ++i) {
    const Triangle t = triangleOf([&] { return places.many(); });
    const glm::vec3 point = places.many();
    const FourTriangles four(t.packed(), t.packed(), t.packed(), t.packed());
    const float height = four.squaredHeights(FourVectors(point))[0];
    const PlaceInTriangle nearest = nearestInTriangle(point - t.a, t.sides());
    const glm::vec2 shares = nearest.shares;
    const bool is_above = shares.x > 0 && shares.y > 0 && shares.x + shares.y < 1;
    EXPECT_EQ(std::isfinite(height), is_above);
    if (is_above) {
      EXPECT_NEAR(height, nearest.squared, 1e-3f * nearest.squared + 1e-3f);
    }
  }
}

TEST(FourTriangles, areInfinitelyFarInEmptySlots) {
  const PackedTriangle none, some = Triangle{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}.packed();
  const glm::vec3 point(0, 0, 2);
  const Four found = FourTriangles(none, some, none, some).squaredDistances({point, point, point, point});
  EXPECT_FALSE(found[0] < std::numeric_limits<float>::infinity());
  EXPECT_FALSE(found[2] < std::numeric_limits<float>::infinity());
  EXPECT_EQ(found[1], 4);
  EXPECT_EQ(found[3], 4);
}

}  // namespace
}  // namespace lode::ingest
