#include "common/lattice.h"

#include <random>

#include <gtest/gtest.h>

namespace lode {
namespace {

TEST(Lattice, packingKeepsAllThreeCoordinates) {
  std::mt19937 random(1);
  for (int i = 0; i < 10000; ++i) {
    const glm::uvec3 p(random() & kMaxLattice, random() & kMaxLattice, random() & kMaxLattice);
    ASSERT_EQ(unpackPosition(packPosition(p)), p);
  }
}

TEST(Lattice, packedPositionsLeaveTheTopBitFree) {
  EXPECT_EQ(packPosition(glm::uvec3(kMaxLattice)).value, (1ull << 63) - 1);
}

TEST(Lattice, snapsToTheNearestPoint) {
  const Lattice lattice{{100, -50, 0}, 0.25};
  EXPECT_EQ(lattice.snap({100.26, -49.9, 0.37}), glm::uvec3(1, 0, 1));
  EXPECT_EQ(lattice.snap({100.38, -49.86, 0.38}), glm::uvec3(2, 1, 2));
}

TEST(Lattice, snapClampsToTheGrid) {
  const Lattice lattice{{0, 0, 0}, 1};
  EXPECT_EQ(lattice.snap({-5, 1e30, kMaxLattice + 0.4}), glm::uvec3(0, kMaxLattice, kMaxLattice));
}

TEST(Lattice, snapsWorldPositionsBackFarFromTheOrigin) {
  const Lattice lattice{{5000000, 400000, -2048}, 1.0 / 1024};
  std::mt19937 random(2);
  for (int i = 0; i < 10000; ++i) {
    const glm::uvec3 p(random() & kMaxLattice, random() & kMaxLattice, random() & kMaxLattice);
    ASSERT_EQ(lattice.snap(lattice.toWorld(p)), p);
  }
}

TEST(Lattice, modelFrameIsExactInFloat) {
  for (const double eighths : {4, 5, 6, 7}) {
    const Lattice lattice{{0, 0, 0}, eighths * 0x1p-13};
    for (const uint32_t i : {1u, 12345u, kMaxLattice - 1, kMaxLattice})
      EXPECT_EQ(double(lattice.toModel(glm::uvec3(i)).x), i * lattice.step) << i;
  }
}

TEST(Lattice, hasStepsOfThreeBitsInRange) {
  for (const double step : {1.0, 5.0, 6 * 0x1p-30, 7 * 0x1p40, kMinStep, kMaxStep})
    EXPECT_TRUE(isLatticeStep(step)) << step;
  for (const double step :
       {0.0, -1.0, 0.3, 9.0, kMinStep / 2, kMaxStep * 1.25, std::nan(""), double(INFINITY)})
    EXPECT_FALSE(isLatticeStep(step)) << step;
}

TEST(LatticeBox, isEmptyUntilAPointIsAdded) {
  LatticeBox box;
  EXPECT_TRUE(box.empty());
  box.add({1, 2, 3});
  EXPECT_FALSE(box.empty());
  EXPECT_EQ(box.min, box.max);
}

TEST(LatticeBox, growsToHoldPointsAndBoxes) {
  LatticeBox box, other;
  box.add({5, 5, 5});
  other.add({1, 9, 5});
  box.add(other);
  EXPECT_EQ(box, (LatticeBox{{1, 5, 5}, {5, 9, 5}}));
  EXPECT_TRUE(box.contains(other));
  EXPECT_FALSE(other.contains(box));
}

TEST(LatticeBox, addingAnEmptyBoxChangesNothing) {
  LatticeBox box{{1, 2, 3}, {4, 5, 6}};
  const LatticeBox before = box;
  box.add(LatticeBox());
  EXPECT_EQ(box, before);
  EXPECT_TRUE(box.contains(LatticeBox()));
}

}  // namespace
}  // namespace lode
