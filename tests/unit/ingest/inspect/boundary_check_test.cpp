#include <initializer_list>

#include <gtest/gtest.h>

#include "server/ingest/inspect/lod_check.h"
#include "tests/support/test_meshes.h"

namespace lode::ingest {
namespace {

constexpr uint32_t kCellsAlong = 20, kCellSteps = 100;

/// Makes the triangles of a flat grid, without some of its cells.
template <typename IsKept>
Mesh gridOf(IsKept&& is_kept) {
  test::MeshOptions options;
  options.extent = kCellsAlong * kCellSteps;
  options.bump = 0;
  Mesh grid = test::makeGrid(kCellsAlong, kCellsAlong, options);
  std::erase_if(grid.triangles, [&](glm::u32vec3 t) {
    const glm::uvec3 a = unpackPosition(grid.positions[t.x]), b = unpackPosition(grid.positions[t.y]),
                     c = unpackPosition(grid.positions[t.z]);
    const glm::uvec3 cell = glm::min(glm::min(a, b), c) / kCellSteps;
    return !is_kept(cell.x, cell.y);
  });
  return grid;
}

float found(const Mesh& lod, std::initializer_list<Mesh> leaves) {
  BoundaryCheck check;
  check.addLod(lod);
  for (const Mesh& leaf : leaves) {
    store::OpenEdges boundaries;
    boundaries.add(leaf);
    check.addLeaf(boundaries.edges());
  }
  return static_cast<float>(check.farthest().at(0).steps);
}

constexpr auto kAll = [](uint32_t, uint32_t) { return true; };
constexpr auto kWithHole = [](uint32_t x, uint32_t y) { return x < 5 || x >= 8 || y < 9 || y >= 11; };

TEST(BoundaryCheck, measuresTheDistanceToTheNearestBoundaryOfTheLeaves) {
  EXPECT_FLOAT_EQ(found(gridOf(kWithHole), {gridOf(kAll)}), 8 * kCellSteps);
}

TEST(BoundaryCheck, findsNothingWhereTheBoundariesAreTheSame) {
  EXPECT_EQ(found(gridOf(kWithHole), {gridOf(kWithHole)}), 0);
}

TEST(BoundaryCheck, ignoresEdgesThatTwoLeavesShare) {
  const Mesh left = gridOf([](uint32_t x, uint32_t) { return x < 6; });
  const Mesh right = gridOf([](uint32_t x, uint32_t) { return x >= 6; });
  EXPECT_FLOAT_EQ(found(gridOf(kWithHole), {left, right}), 8 * kCellSteps);
}

TEST(BoundaryCheck, findsNothingWhereTheLeavesHaveNoBoundaries) {
  EXPECT_EQ(found(gridOf(kAll), {test::makeSphere(12, 8)}), 0);
}

}  // namespace
}  // namespace lode::ingest
