#include "client/app/window/scene/scene_stage.h"

#include <gtest/gtest.h>

namespace lode::app {
namespace {

/// A cube of side 8 with its lowest corner at a point.
ModelSummary cubeAt(const glm::dvec3& min) {
  ModelSummary whole;
  whole.lattice = {min, 0x1p-17};
  whole.box.add(glm::uvec3(0));
  whole.box.add(glm::uvec3(1u << 20));
  return whole;
}

void expectKept(const ModelSummary& cube, const glm::dvec3& min) {
  const Lattice lattice = latticeWithRoom(cube);
  const LatticeBox box = boxIn(lattice, cube);
  EXPECT_LT(glm::distance(lattice.toWorld(box.min), min), 2 * lattice.step);
  EXPECT_LT(glm::distance(lattice.toWorld(box.max), min + 8.0), 2 * lattice.step);
  EXPECT_LT(lattice.step, 1e-3) << "it loses few bits";
}

TEST(SceneFrame, hasRoomOnEachSideForALateModel) {
  const Lattice lattice = latticeWithRoom(cubeAt(glm::dvec3(10)));
  for (const double away : {-500.0, 500.0}) {
    const glm::dvec3 point(14 + away);
    const glm::dvec3 kept = lattice.toWorld(lattice.snap(point));
    EXPECT_LT(glm::distance(kept, point), 2 * lattice.step) << away;
  }
}

TEST(SceneFrame, keepsThePositionOfTheBox) { expectKept(cubeAt(glm::dvec3(10)), glm::dvec3(10)); }

TEST(SceneFrame, keepsThePositionOfABoxFarFromItsModelsOrigin) {
  const glm::dvec3 far_away(4e5, 5e6, 100);
  expectKept(cubeAt(far_away), far_away);
}

TEST(SceneFrame, cutsTheBoxOffWhereItsRoomEnds) {
  const Lattice lattice = latticeWithRoom(cubeAt(glm::dvec3(10)));
  ModelSummary whole = cubeAt(glm::dvec3(10));
  whole.lattice.step *= 1024;  // reaches 8 192 along each axis
  const LatticeBox box = boxIn(lattice, whole);
  EXPECT_LT(glm::distance(lattice.toWorld(box.min), glm::dvec3(10)), 2 * lattice.step);
  EXPECT_EQ(box.max, glm::uvec3(kMaxLattice));
}

}  // namespace
}  // namespace lode::app
