#include "server/ingest/preview/cluster_grid.h"

#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/memory_meter.h"

namespace lode::ingest {
namespace {

TEST(ClusterGrid, coarsensInMemoryThatDoesNotGrowWithTheVertices) {
  constexpr size_t kVertices = 400'000;
  constexpr uint32_t kCells = 1000, kExtent = 60'000;
  const TemporaryFolder folder(testing::TempDir());
  PackedInput input(folder, {}, false);
  std::mt19937 random(1);
  std::vector<PlyVertex> vertices(kVertices);
  for (PlyVertex& vertex : vertices)
    vertex.position = {random() % kExtent, random() % kExtent, random() % kExtent};
  input.addVertices(vertices);
  input.flush();
  ClusterGrid grid(input, Lattice(), glm::uvec3(kExtent), kCells);
  const uint32_t before = grid.cellCount(), width_steps = grid.widthSteps();
  EXPECT_LE(before, kCells);
  const test::MemoryMeter meter;
  grid.coarsen();
  EXPECT_LT(meter.peakBytes(), 1 << 20);
  EXPECT_LT(grid.cellCount(), before);
  EXPECT_EQ(grid.widthSteps(), 2 * width_steps);
}

}  // namespace
}  // namespace lode::ingest
