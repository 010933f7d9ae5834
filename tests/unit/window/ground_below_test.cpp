#include "client/app/window/camera/ground_below.h"

#include <memory>

#include <gtest/gtest.h>

namespace lode::app {
namespace {

constexpr double kStep = 1.0 / 1024;
const glm::dvec3 kZ(0, 0, 1);

/// A square of side 1 at a height, with an error.
core::CutPart squareAt(uint32_t z, float error_px = 0) {
  Mesh mesh;
  for (const glm::uvec2 corner : {glm::uvec2(0, 0), {1024, 0}, {1024, 1024}, {0, 1024}})
    mesh.positions.push_back(packPosition({corner.x, corner.y, z}));
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  core::CutPart part;
  part.node = NodeKey{8};
  part.error_px = error_px;
  part.mesh = std::make_shared<const Mesh>(std::move(mesh));
  return part;
}

core::View lookingAside() {
  core::View view;
  view.eye_model = {0.5, 0.5, 1};
  view.forward = {1, 0, 0};
  view.up = kZ;
  return view;
}

core::Cut cutOf(core::CutPart part) {
  core::Cut cut;
  cut.view = lookingAside();
  cut.parts.push_back(std::move(part));
  return cut;
}

std::optional<render::Ground> below(const core::Cut& cut, const glm::dvec3& point = {0.5, 0.25, 1}) {
  const core::CutProbe probe(std::make_shared<const core::Cut>(cut), kStep);
  return groundBelow(probe, lookingAside(), point, kZ);
}

TEST(GroundBelow, isThePartBelowThoughTheCameraDoesNotLookThere) {
  const auto ground = below(cutOf(squareAt(256)));
  ASSERT_TRUE(ground);
  EXPECT_DOUBLE_EQ(ground->depth_model, 0.75);
  EXPECT_EQ(ground->uncertainty_model, 0);
}

TEST(GroundBelow, isNothingBesideTheModelAndBelowIt) {
  EXPECT_FALSE(below(cutOf(squareAt(256)), {1.5, 0.25, 1}));
  EXPECT_FALSE(below(cutOf(squareAt(256)), {0.5, 0.25, 0.1}));
}

TEST(GroundBelow, isTheCoarserPartWhereTheCutLeavesThePlaceOut) {
  core::Cut cut;
  cut.view = lookingAside();
  cut.left_out.push_back({NodeKey{8}, {{0, 0, 0}, {1, 1, 0.5}}});
  core::Fallback fallback;
  fallback.part = squareAt(128);
  fallback.end_left_out = 1;
  cut.fallbacks.push_back(fallback);
  const auto ground = below(cut);
  ASSERT_TRUE(ground);
  EXPECT_DOUBLE_EQ(ground->depth_model, 0.875);
}

TEST(GroundBelow, isAsUncertainAsThePartsErrorWasBeforeItsProjection) {
  core::Cut cut = cutOf(squareAt(0));
  const float error_model = 0.01f;
  cut.parts[0].error_px = core::screenErrorPx(error_model, 1, cut.view);  // 1 below the eye
  const auto ground = below(cut);
  ASSERT_TRUE(ground);
  EXPECT_NEAR(ground->uncertainty_model, error_model, 1e-6);
}

TEST(GroundBelow, isNoMoreUncertainThanAPartsSizeAllowsHoweverNearItIs) {
  core::Cut cut = cutOf(squareAt(256, 1e9f));
  const auto ground = below(cut);
  ASSERT_TRUE(ground);
  EXPECT_GT(ground->uncertainty_model, 0);
  EXPECT_LT(ground->uncertainty_model, 0.02);
}

}  // namespace
}  // namespace lode::app
