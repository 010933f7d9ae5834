#include "server/ingest/measure/lod_deviation.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "server/ingest/measure/surface_samples.h"
#include "server/ingest/mesh/mesh_welder.h"
#include "server/ingest/simplify/collapse.h"
#include "tests/support/node_meshes.h"

namespace lode::ingest {
namespace {

/// Deviation of a sphere's LOD with 300 triangles.
float deviation(std::optional<float> off_steps, float farthest_sample) {
  const NodeMesh sphere = test::nodeOf(test::makeSphere(60, 40));
  float steps = 0;
  collapse(sphere, std::array<size_t, 1>{300}, {}, [&](size_t, SimplifiedMesh&& lod) {
    const LodSurface surface(lod.mesh);
    const std::vector<SurfaceWalk::Place> places = placesOn(lod, sphere, surface.walk());
    const std::vector<uint32_t> sources = sourcesOf(lod, sphere);
    steps =
        lodDeviation(lod, LodInput(sphere, 0, off_steps), {surface, places, sources}, farthest_sample).steps;
  });
  return steps;
}

TEST(LodDeviation, includesTheDeviationOfItsInput) {
  const float of_original = deviation({}, 0);
  ASSERT_GT(of_original, 0);
  EXPECT_GE(deviation(of_original, 0), 1.4f * of_original);
}

TEST(LodDeviation, isNotBelowASampleOfTheOriginal) {
  const float of_original = deviation({}, 0);
  EXPECT_GE(deviation({}, 3 * of_original), 3 * of_original);
  EXPECT_GE(deviation(of_original, 3 * of_original), 3 * of_original);
}

TEST(LodDeviation, isTheSameWhateverSmallerDeviationIsKnownBefore) {
  const float of_original = deviation({}, 0);
  EXPECT_NEAR(deviation({}, 0.9f * of_original), of_original, 0.03f * of_original);
}

constexpr size_t kFew = 4096, kMany = 16384;  // numbers of triangles

TEST(LodDeviation, addsTheInputsDeviationInQuadratureForFewTriangles) {
  EXPECT_FLOAT_EQ(deviationOfReduced(3 / 1.12f, 4, 4, kFew), 5);
}

TEST(LodDeviation, usesSamplesForManyTriangles) {
  EXPECT_FLOAT_EQ(deviationOfReduced(3 / 1.12f, 4, 3.2f, kMany), 1.3f * 3.2f);
  EXPECT_FLOAT_EQ(deviationOfReduced(3 / 1.12f, 4, 3.2f, 100 * kMany), 1.3f * 3.2f);
}

TEST(LodDeviation, interpolatesBetweenFewAndManyTriangles) {
  EXPECT_FLOAT_EQ(deviationOfReduced(3 / 1.12f, 4, 3.2f, (kFew + kMany) / 2), (5 + 1.3f * 3.2f) / 2);
}

TEST(LodDeviation, neverExceedsTheSumInQuadrature) {
  EXPECT_FLOAT_EQ(deviationOfReduced(3 / 1.12f, 4, 4.5f, kMany), 5);
}

TEST(LodDeviation, isNeverBelowAnyMeasuredDeviation) {
  for (const float from_input : {0.f, 1.f, 3.f})
    for (const float off : {0.f, 1.f, 3.f})
      for (const float sample : {0.f, 1.f, 3.f})
        EXPECT_GE(deviationOfReduced(from_input, off, sample, kMany), std::max({from_input, off, sample}));
}

}  // namespace
}  // namespace lode::ingest
