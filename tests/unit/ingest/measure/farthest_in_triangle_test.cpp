#include "server/ingest/measure/farthest_in_triangle.h"

#include <algorithm>
#include <array>
#include <random>
#include <utility>

#include <gtest/gtest.h>

#include "server/ingest/measure/lod_surface.h"
#include "server/ingest/measure/triangle_tree.h"
#include "tests/support/node_meshes.h"

namespace lode::ingest {
namespace {

constexpr uint32_t kGroundCells = 16, kGroundCell = 64;
constexpr int kSteps = 48;

/// A grid in x and y with random heights up to `height`.
NodeMesh foldedGround(uint32_t height, std::mt19937& random) {
  test::MeshOptions options;
  options.extent = kGroundCells * kGroundCell;
  NodeMesh ground = test::nodeOf(test::makeGrid(kGroundCells, kGroundCells, options));
  for (PositionCode& code : ground.positions) {
    const glm::uvec3 place = unpackPosition(code);
    code = packPosition({place.x, place.y, 100 + random() % height});
  }
  return ground;
}

std::array<glm::vec3, 3> triangleAbove(uint32_t height, std::mt19937& random) {
  const auto along = [&] {
    return static_cast<float>(2 * kGroundCell + random() % (kGroundCell * (kGroundCells - 4)));
  };
  const float x = along(), y = along();
  std::array<glm::vec3, 3> corners;
  for (glm::vec3& corner : corners) {
    const auto aside = [&] { return static_cast<float>(random() % (4 * kGroundCell)) - 2 * kGroundCell; };
    corner = {x + aside(), y + aside(), static_cast<float>(100 + random() % height)};
  }
  return corners;
}

float farthestOfDensePoints(const std::array<glm::vec3, 3>& corners, const TriangleTree& tree) {
  float found = 0;
  for (int i = 0; i <= kSteps; ++i)
    for (int j = 0; i + j <= kSteps; ++j) {
      const glm::vec3 sum = static_cast<float>(i) * corners[0] + static_cast<float>(j) * corners[1] +
                            static_cast<float>(kSteps - i - j) * corners[2];
      found = std::max(found, tree.distance(sum / static_cast<float>(kSteps)));
    }
  return found;
}

TEST(FarthestInTriangle, agreesWithDensePointsAboveFoldsAtAnyTolerance) {
  std::mt19937 random(21);
  for (const uint32_t height : {16u, 48u, 160u}) {
    const NodeMesh ground = foldedGround(height, random);
    const LodSurface surface(ground);
    const TriangleTree tree(ground);
    for (int i = 0; i < 300; ++i) {
      const std::array<glm::vec3, 3> at = triangleAbove(height, random);
      const float found = farthestOfDensePoints(at, tree);
      const float between =
          std::max({glm::distance(at[0], at[1]), glm::distance(at[1], at[2]), glm::distance(at[2], at[0])}) /
          kSteps;
      for (const float share : {0.f, 0.5f, 0.9f}) {
        FarthestInTriangle farthest(surface, share * found, 0.f);
        const auto beside = [&](glm::vec3 point) {
          const TriangleTree::Nearest nearest = tree.nearest(point);
          return MeasuredPoint{point, nearest.distance, nearest.triangle};
        };
        farthest.process({beside(at[0]), beside(at[1]), beside(at[2])});
        EXPECT_GE(1.0201f * farthest.precision(), found) << height << ' ' << i << ' ' << share;
        EXPECT_LE(farthest.largest(), found + between) << height << ' ' << i << ' ' << share;
      }
    }
  }
}

/// A surface that counts distance measurements.
struct CountingSurface {
  const PackedTriangle& triangle(uint32_t number) const { return of.triangle(number); }
  bool chainAlong(const Segment& segment, uint32_t first, uint32_t last, float near_squared,
                  TriangleChain& chain) const {
    return of.chainAlong(segment, first, last, near_squared, chain);
  }
  MeasuredPoint measure(glm::vec3 at, uint32_t hint, float tolerance) const {
    ++measured;
    return of.measure(at, hint, tolerance);
  }

  const LodSurface& of;
  mutable int measured = 0;
};

/// Six triangles around a top at `height` above their boundary.
NodeMesh tent(uint32_t height) {
  NodeMesh mesh;
  mesh.positions = {packPosition({1000, 1000, 1000 + height})};
  for (const glm::ivec2 at :
       {glm::ivec2(400, 0), {200, 350}, {-200, 350}, {-400, 0}, {-200, -350}, {200, -350}})
    mesh.positions.push_back(packPosition({1000 + at.x, 1000 + at.y, 1000}));
  for (uint32_t i = 0; i < 7; ++i) mesh.wedge_position.push_back(i);
  for (uint32_t i = 0; i < 6; ++i) mesh.triangles.push_back({0, 1 + i, 1 + (i + 1) % 6});
  mesh.lca_depth.assign(7, kNeverLocked);
  return mesh;
}

TEST(FarthestInTriangle, needsNoSplitAboveANearVertex) {
  const std::array<glm::vec3, 3> at{{{1100, 1010, 1000}, {940, 1090, 1000}, {950, 905, 1000}}};
  for (const auto& [height, is_cut] : {std::pair(20u, false), std::pair(60u, true)}) {
    const NodeMesh mesh = tent(height);
    const LodSurface surface(mesh);
    const TriangleTree tree(mesh);
    const CountingSurface counting{surface};
    FarthestInTriangle farthest(counting, 25.f, 0.f);
    const auto beside = [&](glm::vec3 point) {
      const TriangleTree::Nearest nearest = tree.nearest(point);
      return MeasuredPoint{point, nearest.distance, nearest.triangle};
    };
    farthest.process({beside(at[0]), beside(at[1]), beside(at[2])});
    EXPECT_EQ(counting.measured > 0, is_cut) << height;
    EXPECT_GE(1.0201f * farthest.precision(), farthestOfDensePoints(at, tree)) << height;
  }
}

}  // namespace
}  // namespace lode::ingest
