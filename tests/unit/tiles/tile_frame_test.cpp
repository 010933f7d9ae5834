#include "server/tiles/tile_frame.h"

#include <gtest/gtest.h>

namespace lode::tiles {
namespace {

ModelSummary summaryWith(glm::dvec3 origin) {
  ModelSummary summary;
  summary.lattice = {origin, 0.5};
  summary.box = {glm::uvec3(0), glm::uvec3(20, 40, 60)};
  return summary;
}

glm::dvec3 apply(const glm::dmat4& matrix, glm::dvec3 point) {
  return glm::dvec3(matrix * glm::dvec4(point, 1));
}

void expectNear(glm::dvec3 found, glm::dvec3 wanted, double tolerance) {
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(found[k], wanted[k], tolerance) << k;
}

TEST(RootTransform, turnsTheUpAxisToZ) {
  const ModelSummary summary = summaryWith({});
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {1.0, -1.0}) {
      glm::dvec3 up(0);
      up[axis] = sign;
      const glm::dmat4 matrix = rootTransform(summary, up, {});
      EXPECT_EQ(apply(matrix, up), glm::dvec3(0, 0, 1)) << axis << sign;
      EXPECT_EQ(glm::determinant(glm::dmat3(matrix)), 1) << axis << sign;
    }
}

TEST(RootTransform, leavesAModelThatIsUprightAsItIs) {
  const glm::dvec3 origin(431000.25, 5300000.5, 512);
  const glm::dmat4 matrix = rootTransform(summaryWith(origin), {0, 0, 1}, {});
  EXPECT_EQ(apply(matrix, {1, 2, 3}), origin + glm::dvec3(1, 2, 3));
}

TEST(RootTransform, showsAModelWithYUpFromItsFront) {
  EXPECT_EQ(apply(rootTransform(summaryWith({}), {0, 1, 0}, {}), {1, 2, 3}), glm::dvec3(1, -3, 2));
}

TEST(RootTransform, putsTheMiddleOfTheFootAtThePlace) {
  const ModelSummary summary = summaryWith({1e6, 1e6, 1e6});  // an arbitrary box
  const glm::dmat4 matrix = rootTransform(summary, {0, 0, 1}, GeoPosition{0, 0, 100});
  const glm::dvec3 foot(5, 10, 0);
  expectNear(apply(matrix, foot), {6378237, 0, 0}, 1e-8);
  expectNear(apply(matrix, foot + glm::dvec3(1, 0, 0)), {6378237, 1, 0}, 1e-8);  // east
  expectNear(apply(matrix, foot + glm::dvec3(0, 1, 0)), {6378237, 0, 1}, 1e-8);  // north
  expectNear(apply(matrix, foot + glm::dvec3(0, 0, 1)), {6378238, 0, 0}, 1e-8);
}

TEST(RootTransform, standsOnTheEllipsoid) {
  // Geodetic to Earth-centred coordinates of WGS 84, computed in Python.
  const glm::dmat4 matrix = rootTransform(summaryWith({}), {0, 1, 0}, GeoPosition{7.44, 46.95, 540});
  expectNear(apply(matrix, {5, 0, 15}), {4325395.2525, 564841.6705, 4638366.7250}, 1e-3);
  const glm::dmat4 pole = rootTransform(summaryWith({}), {0, 0, 1}, GeoPosition{0, 90, 0});
  expectNear(apply(pole, {5, 10, 0}), {0, 0, 6356752.314245}, 1e-6);
}

TEST(ModelBox, isAtLeastAStepThick) {
  const ModelBox box = toModelBox({{10, 20, 30}, {20, 20, 31}}, 0.5);
  EXPECT_EQ(box.centre, glm::dvec3(7.5, 10, 15.25));
  EXPECT_EQ(box.half, glm::dvec3(2.5, 0.25, 0.25));
}

TEST(ModelBox, ofNothingIsAStepThick) { EXPECT_EQ(toModelBox({}, 0.5).half, glm::dvec3(0.25)); }

}  // namespace
}  // namespace lode::tiles
