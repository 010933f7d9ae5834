#include "server/ingest/measure/farthest_in_triangle.h"

#include <algorithm>
#include <array>
#include <random>

#include <gtest/gtest.h>

#include "server/ingest/measure/rung_surface.h"
#include "server/ingest/measure/triangle_tree.h"
#include "tests/support/node_meshes.h"

namespace lode::ingest {
namespace {

constexpr uint32_t kGroundCells = 16, kGroundCell = 64;
constexpr int kSteps = 48;

/// A grid in x and y, each of its points raised by up to so much.
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

TEST(FarthestInTriangle, isWhatDensePointsFindAboveFoldsHoweverMuchNeedNotBeToldApart) {
  std::mt19937 random(21);
  for (const uint32_t height : {16u, 48u, 160u}) {
    const NodeMesh ground = foldedGround(height, random);
    const RungSurface surface(ground);
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
          return PointBeside{point, nearest.distance, nearest.triangle};
        };
        farthest.look({beside(at[0]), beside(at[1]), beside(at[2])});
        EXPECT_GE(1.0201f * farthest.told(), found) << height << ' ' << i << ' ' << share;
        EXPECT_LE(farthest.largest(), found + between) << height << ' ' << i << ' ' << share;
      }
    }
  }
}

}  // namespace
}  // namespace lode::ingest
