#include "client/app/window/scene_frame.h"

#include <vector>

#include <gtest/gtest.h>

namespace lode::app {
namespace {

/// From 10 to 18 along each axis.
ModelSummary cube() {
  ModelSummary whole;
  whole.lattice = {glm::dvec3(10), 0x1p-17};
  whole.box.add(glm::uvec3(0));
  whole.box.add(glm::uvec3(1u << 20));
  return whole;
}

SceneInstance at(const glm::dvec3& position) { return {0, {.position = position}}; }

TEST(SceneFrame, hasRoomOnEachSideForAModelThatComesLate) {
  const std::vector<SceneInstance> instances{at({-10, 14, 14}), at({30, 14, 14})};
  const Lattice lattice = latticeWithRoom(cube(), instances);
  for (const glm::dvec3& point : {glm::dvec3(-50, -26, -26), glm::dvec3(70, 58, 58)}) {
    const glm::dvec3 kept = lattice.toWorld(lattice.snap(point));
    EXPECT_LT(glm::distance(kept, point), 2 * lattice.step) << point.x;
  }
}

TEST(SceneFrame, keepsWhereTheBoxIs) {
  const Lattice lattice = latticeWithRoom(cube(), {});
  const LatticeBox box = boxIn(lattice, cube());
  EXPECT_LT(glm::distance(lattice.toWorld(box.min), glm::dvec3(10)), 2 * lattice.step);
  EXPECT_LT(glm::distance(lattice.toWorld(box.max), glm::dvec3(18)), 2 * lattice.step);
  EXPECT_LT(lattice.step, 1e-4) << "it loses few bits";
}

}  // namespace
}  // namespace lode::app
