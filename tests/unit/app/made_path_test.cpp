#include "client/app/cli/made_path.h"

#include <algorithm>
#include <array>

#include <gtest/gtest.h>

#include "client/core/view/framing.h"

namespace lode::app {
namespace {

constexpr std::array kKinds{MadePath::kOrbit, MadePath::kFly, MadePath::kWalk};

/// Returns a model of 100 x 200 x 400 units with its centre at (550, 600, 700).
ModelSummary makeModel() {
  ModelSummary model;
  model.lattice.step = 0.5;
  model.lattice.origin = {500, 500, 500};
  model.box.add(glm::uvec3(0, 0, 0));
  model.box.add(glm::uvec3(200, 400, 800));
  return model;
}

double fromMiddle(const glm::dvec3& at) { return glm::distance(at, glm::dvec3(550, 600, 700)); }

TEST(MadePath, isTheSameForTheSameSeedAndAnotherForAnother) {
  for (const MadePath kind : kKinds) {
    EXPECT_EQ(makePath(kind, makeModel(), 3).keys, makePath(kind, makeModel(), 3).keys);
    EXPECT_NE(makePath(kind, makeModel(), 3).keys, makePath(kind, makeModel(), 4).keys);
  }
}

TEST(MadePath, hasRisingTimesAndValidCameras) {
  for (const MadePath kind : kKinds) {
    for (uint64_t seed = 0; seed < 50; ++seed) {
      const core::CameraPath path = makePath(kind, makeModel(), seed);
      for (size_t i = 0; i < path.keys.size(); ++i) {
        const core::CameraKey& key = path.keys[i];
        EXPECT_GT(glm::length(glm::cross(key.target - key.eye, key.up)), 0);
        EXPECT_TRUE(i == 0 || key.t > path.keys[i - 1].t);
      }
    }
  }
}

TEST(MadePath, orbitsFromTheFramingCameraForSeed0) {
  const core::CameraKey framing = core::framingCamera(makeModel()).keys.front();
  const core::CameraPath path = makePath(MadePath::kOrbit, makeModel(), 0);
  EXPECT_EQ(path.keys.front().eye, framing.eye);
  EXPECT_NEAR(fromMiddle(path.keys.back().eye), fromMiddle(framing.eye) / 2, 1e-6);
}

TEST(MadePath, fliesThroughTheModel) {
  for (uint64_t seed = 0; seed < 50; ++seed) {
    const core::CameraPath path = makePath(MadePath::kFly, makeModel(), seed);
    const glm::dvec3 first = path.keys.front().eye, last = path.keys.back().eye;
    const double across = 2 * glm::length(glm::dvec3(50, 100, 200));
    EXPECT_GT(glm::distance(first, last), across / 2);
    double nearest = across;
    for (const core::CameraKey& key : path.keys) nearest = std::min(nearest, fromMiddle(key.eye));
    EXPECT_LT(nearest, across / 4);
  }
}

TEST(MadePath, walksNearAndFar) {
  const double framing = fromMiddle(core::framingCamera(makeModel()).keys.front().eye);
  double nearest = framing, farthest = 0;
  for (const core::CameraKey& key : makePath(MadePath::kWalk, makeModel(), 1).keys) {
    nearest = std::min(nearest, glm::distance(key.eye, key.target));
    farthest = std::max(farthest, glm::distance(key.eye, key.target));
  }
  EXPECT_LT(nearest, 0.3 * framing);
  EXPECT_GT(farthest, 0.8 * framing);
}

TEST(MadePath, existsForAModelWithoutTriangles) {
  for (const MadePath kind : kKinds) EXPECT_FALSE(makePath(kind, ModelSummary(), 1).keys.empty());
}

}  // namespace
}  // namespace lode::app
