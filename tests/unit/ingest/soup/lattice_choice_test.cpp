#include "server/ingest/soup/lattice_choice.h"

#include <cmath>

#include <gtest/gtest.h>

#include "common/error.h"

namespace lode::ingest {
namespace {

TEST(ChooseStep, isTheLargestAtMostAThirtySecondOfTheFifthPercentileEdge) {
  std::vector<double> edges;
  for (int i = 1; i <= 100; ++i) edges.push_back(i * 1.1);
  const double step = chooseStep(edges, {0, 0, 0}, {1000, 100, 100});
  EXPECT_EQ(step, 0.1875) << "6 / 32, of 6.6 / 32";
  EXPECT_TRUE(isLatticeStep(step));
}

TEST(ChooseStep, keepsCornersOfAModelThatFillsTheScreenWithinAPixel) {
  for (const double side : {1.0, 3.0, 1.9, 1e-3, 777.0}) {
    std::vector<double> edges(10, side);
    const double step = chooseStep(edges, {0, 0, 0}, {side, side, side});
    constexpr double kScreenPx = 3840;
    EXPECT_LE(std::sqrt(3) / 2 * step * kScreenPx / side, 1) << side;
    EXPECT_GE(step, side / 8192) << side;
  }
}

TEST(ChooseStep, hasMultiplesThatDoubleRepresents) {
  for (const double edge : {3.1e-5, 3.7e-5, 4.3e-5, 5.1e-5})
    for (const double far : {1e9 + 1. / 3, 3e9 + 1. / 7}) {
      std::vector<double> edges{edge};
      const double step = chooseStep(edges, glm::dvec3(far), glm::dvec3(far + 0.5));
      const double multiple = std::floor(far / step) * step;
      EXPECT_EQ(std::fmod(multiple, step), 0) << step;
    }
}

TEST(ChooseStep, hasMultiplesThatDoubleRepresentsBelowANegativeCorner) {
  const double spacing = 180 * 0x1p-33;
  std::vector<double> edges{spacing};
  const double step = chooseStep(edges, glm::dvec3(-0x1p20), glm::dvec3(-0x1p20 + 169 * spacing));
  EXPECT_EQ(std::fmod(std::floor(-0x1p20 / step) * step, step), 0) << step;
}

TEST(ChooseStep, leavesOutEdgesWithoutLength) {
  std::vector<double> edges(1000, 0.0);
  edges.insert(edges.end(), 100, 64.0);
  EXPECT_EQ(chooseStep(edges, {0, 0, 0}, {1e4, 100, 100}), 2.0);
}

TEST(ChooseStep, isCoarseEnoughForTheBoxToFitTheLattice) {
  std::vector<double> edges{1e-6};
  const double step = chooseStep(edges, {0, 0, 0}, {1000, 1, 1});
  EXPECT_LE(1000 / step, kMaxLattice - 1);
  EXPECT_GT(1000 / step, kMaxLattice / 4);
}

TEST(ChooseStep, isCoarseEnoughForDoubleToHoldTheCoordinates) {
  std::vector<double> edges{1e-9};
  const double far = 1e9;
  const double step = chooseStep(edges, {far, 0, 0}, {far + 1e-6, 1e-6, 1e-6});
  EXPECT_EQ(std::floor(far / step) * step, far - std::fmod(far, step));
  EXPECT_GE(step, far * 1e-16);
}

struct LatticeFixture : testing::Test {
  TemporaryFolder folder{testing::TempDir()};
  PackedInput input{folder, AttributeSet{}, true};

  void add(std::vector<glm::dvec3> positions, std::vector<uint64_t> corners) {
    std::vector<PlyVertex> vertices;
    for (const glm::dvec3 position : positions) vertices.push_back({.position = position});
    input.addVertices(vertices);
    PlyFaces faces;
    faces.corner_counts.assign(corners.size() / 3, 3);
    faces.corners = std::move(corners);
    input.addFaces(faces);
    input.flush();
  }
};

TEST_F(LatticeFixture, isNotStretchedByAVertexThatNoFaceUses) {
  add({{5e5, 5e5, 0}, {5e5 + 1, 5e5, 0}, {5e5, 5e5 + 1, 1}, {0, 0, 0}}, {0, 1, 2});
  const LatticeChoice choice = chooseLattice(input, "stray.ply");
  EXPECT_NEAR(choice.lattice.origin.x, 5e5, choice.lattice.step);
  EXPECT_EQ(choice.lattice.step, 1.0 / 4096);
  EXPECT_EQ(choice.extent, glm::uvec3(4096));
}

TEST_F(LatticeFixture, putsTheOriginOnAMultipleOfTheStepAtOrBelowTheBox) {
  add({{-7.3, 1.1, 2.2}, {-6.3, 1.1, 2.2}, {-7.3, 2.1, 3.2}}, {0, 1, 2});
  const Lattice lattice = chooseLattice(input, "any.ply").lattice;
  EXPECT_EQ(std::fmod(lattice.origin.x, lattice.step), 0.0);
  EXPECT_LE(lattice.origin.x, -7.3);
  EXPECT_GT(lattice.origin.x, -7.3 - lattice.step);
}

/// Makes so many edges that one short edge does not change the percentile.
std::vector<uint64_t> amongManyFaces(std::vector<uint64_t> corners) {
  for (int i = 0; i < 40; ++i) corners.insert(corners.end(), {0, 1, 2});
  return corners;
}

TEST_F(LatticeFixture, isRefinedUntilDistinctCornersStayDistinct) {
  add({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1e-5, 1e-5, 0}}, amongManyFaces({0, 3, 1}));
  const Lattice lattice = chooseLattice(input, "sliver.ply").lattice;
  EXPECT_NE(lattice.snap({0, 0, 0}), lattice.snap({1e-5, 1e-5, 0}));
  EXPECT_GT(lattice.step, 1e-6) << "and no finer";
}

TEST_F(LatticeFixture, isNotMadeFinerForFacesThatAreFlatInTheFile) {
  add({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}}, amongManyFaces({0, 3, 1}));
  EXPECT_EQ(chooseLattice(input, "flat.ply").lattice.step, 1.0 / 4096);
}

TEST_F(LatticeFixture, isNotMadeFinerForCornersThatNoLatticeHoldsApart) {
  add({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1e-12, 0, 0}}, amongManyFaces({0, 3, 2}));
  EXPECT_EQ(chooseLattice(input, "nearly-flat.ply").lattice.step, 1.0 / 4096);
}

TEST_F(LatticeFixture, refusesCoordinatesTooSmallForAStore) {
  add({{0, 0, 0}, {1e-40, 0, 0}, {0, 1e-40, 0}}, {0, 1, 2});
  EXPECT_THROW(chooseLattice(input, "tiny.ply"), Error);
}

TEST_F(LatticeFixture, refusesCoordinatesTooLargeForAStore) {
  add({{0, 0, 0}, {1e40, 0, 0}, {0, 1e40, 0}}, {0, 1, 2});
  EXPECT_THROW(chooseLattice(input, "huge.ply"), Error);
}

TEST_F(LatticeFixture, refusesAModelWhoseVerticesAllCoincide) {
  add({{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}, {0, 1, 2});
  EXPECT_THROW(chooseLattice(input, "point.ply"), Error);
}

}  // namespace
}  // namespace lode::ingest
