#include "client/core/lod/cut_probe.h"

#include <numeric>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/test_meshes.h"

namespace lode::core {
namespace {

constexpr double kStep = 1.0 / 1024;

std::shared_ptr<const Cut> cutOf(std::vector<Mesh> meshes) {
  auto cut = std::make_shared<Cut>();
  for (Mesh& mesh : meshes) {
    CutPart& part = cut->parts.emplace_back();
    part.node = NodeKey{8 + cut->parts.size() - 1};
    part.mesh = std::make_shared<const Mesh>(std::move(mesh));
  }
  return cut;
}

Mesh squareAt(uint32_t z) {
  Mesh mesh;
  for (const glm::uvec2 corner : {glm::uvec2(0, 0), {1024, 0}, {1024, 1024}, {0, 1024}})
    mesh.positions.push_back(packPosition({corner.x, corner.y, z}));
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

/// Casts a ray with all parts of the cut drawn.
std::optional<Hit> cast(const CutProbe& probe, const Ray& ray) {
  std::vector<uint32_t> shown(probe.cut()->parts.size());
  std::iota(shown.begin(), shown.end(), 0u);
  return probe.cast(ray, shown);
}

TEST(CutProbe, findsTheNearestOfSeveralParts) {
  const CutProbe probe(cutOf({squareAt(0), squareAt(512), squareAt(256)}), kStep);
  const auto hit = cast(probe, {{0.5, 0.25, 3}, {0, 0, -1}});
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->part, &probe.cut()->parts[1]);
  EXPECT_EQ(hit->position_model, glm::dvec3(0.5, 0.25, 0.5));
  EXPECT_EQ(hit->distance_model, 2.5);
}

TEST(CutProbe, hitsAFallbackThatIsDrawnInsteadOfTheCut) {
  auto cut = std::make_shared<Cut>(*cutOf({squareAt(512)}));
  Fallback& fallback = cut->fallbacks.emplace_back();
  fallback.part = cutOf({squareAt(256)})->parts[0];
  const CutProbe probe(cut, kStep);
  const Ray down{{0.5, 0.25, 3}, {0, 0, -1}};
  EXPECT_EQ(probe.cast(down, std::vector<uint32_t>{0})->part, &cut->parts[0]);
  EXPECT_EQ(probe.cast(down, std::vector<uint32_t>{1})->part, &cut->fallbacks[0].part);
}

TEST(CutProbe, givesTheTriangleAndTheBarycentricWeights) {
  const auto hit = cast(CutProbe(cutOf({squareAt(0)}), kStep), {{0.5, 0.25, 3}, {0, 0, -1}});
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->triangle, 0u);
  EXPECT_LT(glm::distance(hit->weights, glm::dvec3(0.5, 0.25, 0.25)), 1e-12);
}

TEST(CutProbe, seesTrianglesFromBothSidesAndNothingBehindTheEye) {
  const CutProbe probe(cutOf({squareAt(0)}), kStep);
  EXPECT_TRUE(cast(probe, {{0.5, 0.5, -3}, {0, 0, 1}}));
  EXPECT_FALSE(cast(probe, {{0.5, 0.5, -3}, {0, 0, -1}}));
}

TEST(CutProbe, missesTrianglesBesideTheRay) {
  const CutProbe probe(cutOf({squareAt(0)}), kStep);
  EXPECT_FALSE(cast(probe, {{1.5, 0.5, 3}, {0, 0, -1}}));
  EXPECT_FALSE(cast(CutProbe(cutOf({}), kStep), {{0.5, 0.5, 3}, {0, 0, -1}}));
}

TEST(CutProbe, findsAClosedSurfaceFromWithinInEveryDirection) {
  const CutProbe probe(cutOf({test::makeSphere(24, 12, {.attributes = {}, .bump = 0})}), kStep);
  std::mt19937 random(1);
  std::normal_distribution<double> part;
  for (int i = 0; i < 1000; ++i) {
    const glm::dvec3 direction = glm::normalize(glm::dvec3(part(random), part(random), part(random)));
    const auto hit = cast(probe, {glm::dvec3(2), direction});
    ASSERT_TRUE(hit);
    EXPECT_NEAR(hit->distance_model, 2, 0.1);
  }
}

TEST(Ray, goesThroughThePlaceOfThePicture) {
  View view;
  view.eye_model = {3, 4, 5};
  view.width_px = 200;
  view.height_px = 100;
  EXPECT_EQ(rayThrough(view, {100, 50}).direction, view.forward);
  const glm::dvec3 top = rayThrough(view, {100, 0}).direction;
  EXPECT_NEAR(std::acos(glm::dot(top, view.forward)), view.fov_y_rad / 2, 1e-12);
  EXPECT_GT(top.y, 0);
  EXPECT_GT(rayThrough(view, {150, 50}).direction.x, 0);
}

}  // namespace
}  // namespace lode::core
