#include "server/ingest/soup/lattice_choice.h"

#include <cmath>

#include <gtest/gtest.h>

#include "common/error.h"

namespace lode::ingest {
namespace {

TEST(ChooseStep, isThePowerOfTwoBelowAThirtySecondOfTheFifthPercentileEdge) {
  std::vector<double> edges;
  for (int i = 1; i <= 100; ++i) edges.push_back(i);
  EXPECT_EQ(chooseStep(edges, {0, 0, 0}, {100, 100, 100}), 0.125);
}

TEST(ChooseStep, leavesOutEdgesWithoutLength) {
  std::vector<double> edges(1000, 0.0);
  edges.insert(edges.end(), 100, 64.0);
  EXPECT_EQ(chooseStep(edges, {0, 0, 0}, {100, 100, 100}), 2.0);
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
  EXPECT_EQ(choice.lattice.step, 1.0 / 32);
  EXPECT_EQ(choice.extent, glm::uvec3(32));
}

TEST_F(LatticeFixture, putsTheOriginOnAMultipleOfTheStepAtOrBelowTheBox) {
  add({{-7.3, 1.1, 2.2}, {-6.3, 1.1, 2.2}, {-7.3, 2.1, 3.2}}, {0, 1, 2});
  const Lattice lattice = chooseLattice(input, "any.ply").lattice;
  EXPECT_EQ(std::fmod(lattice.origin.x, lattice.step), 0.0);
  EXPECT_LE(lattice.origin.x, -7.3);
  EXPECT_GT(lattice.origin.x, -7.3 - lattice.step);
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
