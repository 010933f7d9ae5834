#include "server/ingest/soup/triangulate.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

namespace lode::ingest {
namespace {

using Polygon = std::vector<glm::dvec3>;

glm::dvec3 areaVector(const Polygon& polygon) {
  glm::dvec3 sum(0);
  for (size_t i = 0; i < polygon.size(); ++i) {
    sum += glm::cross(polygon[i] - polygon[0], polygon[(i + 1) % polygon.size()] - polygon[0]);
  }
  return sum * 0.5;
}

/// Expects that outline edges are used once, forwards, and all others twice, in both directions.
void expectClosesTheOutline(size_t corners, const std::vector<glm::u32vec3>& triangles) {
  ASSERT_EQ(triangles.size(), corners - 2);
  std::map<std::pair<uint32_t, uint32_t>, int> uses;
  for (const glm::u32vec3& triangle : triangles) {
    for (int i = 0; i < 3; ++i) ++uses[{triangle[i], triangle[(i + 1) % 3]}];
  }
  for (const auto& [edge, count] : uses) {
    EXPECT_EQ(count, 1);
    const bool outline = edge.second == (edge.first + 1) % corners;
    EXPECT_EQ(uses.contains({edge.second, edge.first}), !outline) << edge.first << " " << edge.second;
  }
  for (uint32_t i = 0; i < corners; ++i)
    EXPECT_TRUE(uses.contains({i, static_cast<uint32_t>((i + 1) % corners)})) << i;
}

/// Expects that all triangles have the polygon's orientation and their areas sum to its area.
void expectCoversExactly(const Polygon& polygon) {
  std::vector<glm::u32vec3> triangles;
  triangulate(polygon, triangles);
  expectClosesTheOutline(polygon.size(), triangles);
  const glm::dvec3 whole = areaVector(polygon);
  const glm::dvec3 normal = glm::normalize(whole);
  double sum = 0;
  for (const glm::u32vec3& t : triangles) {
    const double area = glm::dot(areaVector({polygon[t.x], polygon[t.y], polygon[t.z]}), normal);
    EXPECT_GE(area, -1e-12 * glm::length(whole));
    sum += std::fabs(area);
  }
  EXPECT_NEAR(sum, glm::length(whole), 1e-9 * glm::length(whole));
}

glm::dmat3 randomFrame(std::mt19937& random) {
  std::normal_distribution<double> normal;
  const auto direction = [&] {
    return glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
  };
  const glm::dvec3 x = direction();
  const glm::dvec3 y = glm::normalize(glm::cross(x, direction()));
  return {x, y, glm::cross(x, y)};
}

Polygon inSpace(const std::vector<glm::dvec2>& flat, std::mt19937& random, glm::dvec3 origin = {}) {
  const glm::dmat3 frame = randomFrame(random);
  Polygon polygon;
  for (const glm::dvec2& p : flat) polygon.push_back(origin + frame * glm::dvec3(p, 0));
  return polygon;
}

bool crosses(glm::dvec2 a, glm::dvec2 b, glm::dvec2 c, glm::dvec2 d) {
  const auto side = [](glm::dvec2 p, glm::dvec2 q, glm::dvec2 r) {
    return (q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x) > 0;
  };
  return side(a, b, c) != side(a, b, d) && side(c, d, a) != side(c, d, b);
}

/// Makes a simple polygon of random points: joins them in random order, then reverses ranges between crossing
/// edges.
std::vector<glm::dvec2> randomSimplePolygon(size_t corners, std::mt19937& random) {
  std::uniform_real_distribution<double> unit;
  std::vector<glm::dvec2> points(corners);
  for (glm::dvec2& p : points) p = {unit(random), unit(random)};
  for (bool changed = true; changed;) {
    changed = false;
    for (size_t i = 0; i < corners; ++i) {
      for (size_t j = i + 2; j < corners; ++j) {
        if (i == 0 && j + 1 == corners) continue;
        if (!crosses(points[i], points[i + 1], points[j], points[(j + 1) % corners])) continue;
        std::reverse(points.begin() + static_cast<long>(i) + 1, points.begin() + static_cast<long>(j) + 1);
        changed = true;
      }
    }
  }
  return points;
}

TEST(Triangulate, leavesTrianglesAsTheyAre) {
  std::vector<glm::u32vec3> triangles{{9, 9, 9}};
  triangulate(Polygon{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, triangles);
  EXPECT_EQ(triangles, (std::vector<glm::u32vec3>{{0, 1, 2}}));
}

TEST(Triangulate, cutsConvexQuadsAlongTheShorterDiagonal) {
  std::vector<glm::u32vec3> triangles;
  triangulate(Polygon{{0, 0, 0}, {2, 0, 0}, {3, 1, 0}, {1, 1, 0}}, triangles);
  EXPECT_EQ(triangles, (std::vector<glm::u32vec3>{{0, 1, 3}, {1, 2, 3}}));
}

TEST(Triangulate, coversQuadsThatAreNotConvex) {
  std::mt19937 random(1);
  const std::vector<glm::dvec2> dart{{0, 0}, {2, 1}, {0, 2}, {0.5, 1}};
  for (size_t turn = 0; turn < 4; ++turn) {
    std::vector<glm::dvec2> turned = dart;
    std::rotate(turned.begin(), turned.begin() + static_cast<long>(turn), turned.end());
    expectCoversExactly(inSpace(turned, random));
    std::reverse(turned.begin(), turned.end());
    expectCoversExactly(inSpace(turned, random));
  }
}

TEST(Triangulate, coversRandomSimplePolygonsExactly) {
  std::mt19937 random(2);
  for (int i = 0; i < 400; ++i) {
    const size_t corners = 4 + random() % 40;
    SCOPED_TRACE(i);
    expectCoversExactly(inSpace(randomSimplePolygon(corners, random), random, {1e3, -2e3, 5}));
  }
}

TEST(Triangulate, coversLargeCombsStarsAndSpiralsExactly) {
  std::mt19937 random(3);
  std::vector<glm::dvec2> comb;
  for (int i = 0; i < 1000; ++i) comb.emplace_back(i, i % 2 ? 1 : 100);
  comb.emplace_back(1000, 0);
  comb.emplace_back(-1, 0);
  expectCoversExactly(inSpace(comb, random));
  std::vector<glm::dvec2> star;
  for (int i = 0; i < 2000; ++i) {
    const double angle = i * std::numbers::pi / 1000;
    star.push_back(glm::dvec2(std::cos(angle), std::sin(angle)) * (i % 2 ? 1.0 : 0.3));
  }
  expectCoversExactly(inSpace(star, random));
  std::vector<glm::dvec2> spiral;
  const auto at = [](int i, double radius) {
    return glm::dvec2(std::cos(i * 0.05), std::sin(i * 0.05)) * (radius + i * 0.05);
  };
  for (int i = 0; i < 10'000; ++i) spiral.push_back(at(i, 1));
  for (int i = 10'000; i-- > 0;) spiral.push_back(at(i, 1.3));
  expectCoversExactly(inSpace(spiral, random));
}

TEST(Triangulate, coversOutlinesWithStraightCorners) {
  std::vector<glm::dvec3> square;
  for (int i = 0; i < 5; ++i) square.emplace_back(i, 0, 0);
  for (int i = 0; i < 5; ++i) square.emplace_back(5, i, 0);
  for (int i = 0; i < 5; ++i) square.emplace_back(5 - i, 5, 0);
  for (int i = 0; i < 5; ++i) square.emplace_back(0, 5 - i, 0);
  expectCoversExactly(square);
  expectCoversExactly({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {1, 1, 0}, {0.5, 0.5, 0}});
}

TEST(Triangulate, closesOutlinesThatAreFlatOrTangledOrAPoint) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> unit;
  const double huge = 1e308;
  std::vector<Polygon> polygons{Polygon(6, {1, 2, 3}),
                                {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {4, 0, 0}},
                                {{huge, 0, 0}, {-huge, 0, 0}, {0, huge, 0}, {0, -huge, 0}, {0, 0, huge}},
                                Polygon(4, {0, 0, 0})};
  for (int i = 0; i < 200; ++i) {
    Polygon& tangled = polygons.emplace_back(4 + random() % 30);
    for (glm::dvec3& p : tangled) p = {unit(random), unit(random), unit(random)};
  }
  std::vector<glm::u32vec3> triangles;
  for (const Polygon& polygon : polygons) {
    triangulate(polygon, triangles);
    expectClosesTheOutline(polygon.size(), triangles);
  }
}

TEST(Triangulate, boundsItsWorkOnTheWorstPolygons) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit;
  Polygon tangled(1 << 16);
  for (glm::dvec3& p : tangled) p = {unit(random), unit(random), unit(random)};
  std::vector<glm::u32vec3> triangles;
  triangulate(tangled, triangles);
  EXPECT_EQ(triangles.size(), tangled.size() - 2);
}

}  // namespace
}  // namespace lode::ingest
