#include "server/ingest/measure/rung_deviation.h"

#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "server/ingest/measure/surface_samples.h"
#include "server/ingest/mesh/mesh_welder.h"
#include "server/ingest/simplify/collapse.h"
#include "tests/support/node_meshes.h"

namespace lode::ingest {
namespace {

/// Of a sphere's rung of 300 triangles.
float deviation(std::optional<float> off_steps, float farthest_sample) {
  const NodeMesh sphere = test::nodeOf(test::makeSphere(60, 40));
  float steps = 0;
  collapse(sphere, std::array<size_t, 1>{300}, {}, [&](size_t, SimplifiedMesh&& rung) {
    const RungSurface surface(rung.mesh);
    const std::vector<SurfaceWalk::Place> places = placesOn(rung, sphere, surface.walk());
    const std::vector<uint32_t> sources = sourcesOf(rung, sphere);
    steps = rungDeviation(rung, RungInput(sphere, 0, off_steps), {surface, places, sources}, farthest_sample);
  });
  return steps;
}

TEST(RungDeviation, countsWhatTheRungsInputIsOffBy) {
  const float of_original = deviation({}, 0);
  ASSERT_GT(of_original, 0);
  EXPECT_GE(deviation(of_original, 0), 1.4f * of_original);
}

TEST(RungDeviation, isNotBelowASampleOfTheOriginal) {
  const float of_original = deviation({}, 0);
  EXPECT_GE(deviation({}, 3 * of_original), 3 * of_original);
  EXPECT_GE(deviation(of_original, 3 * of_original), 3 * of_original);
}

TEST(RungDeviation, isTheSameWhateverSmallerDeviationIsKnownBefore) {
  const float of_original = deviation({}, 0);
  EXPECT_NEAR(deviation({}, 0.9f * of_original), of_original, 0.03f * of_original);
}

}  // namespace
}  // namespace lode::ingest
