#include "client/core/lod/seen_places.h"

#include <gtest/gtest.h>

#include "tests/unit/core/scripted_client.h"

namespace lode::core {
namespace {

using namespace fixture;

constexpr NodeKey kLeftOfAll{0b1'000}, kRightOfAll{0b1'001};  // children of the root with y = z = 0

ModelSummary summary() {
  ModelSummary model;
  model.lattice = SyntheticModel::lattice();
  model.box.add(glm::uvec3(0));
  model.box.add(glm::uvec3(1u << 20));
  return model;
}

/// An upright rectangle at a depth of the model, from one side to the other.
CutPart wall(double left, double right, double depth) {
  Mesh mesh;
  for (const auto& [x, y] : {std::pair{left, 0.}, {right, 0.}, {right, 500.}, {left, 500.}})
    mesh.positions.push_back(packPosition(glm::uvec3(glm::dvec3(x, y, depth) * 1024.0)));
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return {kRootKey, 0, true, 0, std::make_shared<const Mesh>(std::move(mesh))};
}

SeenPlaces placesOf(std::initializer_list<CutPart> parts, const View& view) {
  Cut cut;
  cut.parts = parts;
  cut.view = view;
  return SeenPlaces::of(cut, summary()).value();
}

const View kFromTheFront = lookingAt({512, 250, 2000}, {512, 250, 0});

TEST(SeenPlaces, areWhereTheSurfaceIs) {
  const SeenPlaces places = placesOf({wall(0, 500, 100)}, kFromTheFront);
  EXPECT_TRUE(places.in(kRootKey));
  EXPECT_TRUE(places.in(kLeftOfAll));
  EXPECT_FALSE(places.in(kRightOfAll));
}

TEST(SeenPlaces, areNotBehindOtherParts) {
  const SeenPlaces places = placesOf({wall(0, 1000, 100), wall(400, 1000, 900)}, kFromTheFront);
  EXPECT_TRUE(places.in(kLeftOfAll));
  EXPECT_FALSE(places.in(kRightOfAll));
}

TEST(SeenPlaces, doNotDependOnTheOrderOfParts) {
  const SeenPlaces places = placesOf({wall(400, 1000, 900), wall(0, 1000, 100)}, kFromTheFront);
  EXPECT_FALSE(places.in(kRightOfAll));
}

TEST(SeenPlaces, areNotBesideThePictureAndItsMargin) {
  const SeenPlaces places =
      placesOf({wall(0, 500, 100), wall(520, 1000, 100)}, lookingAt({750, 250, 300}, {750, 250, 0}));
  EXPECT_FALSE(places.in(kLeftOfAll));
  EXPECT_TRUE(places.in(kRightOfAll));
}

TEST(SeenPlaces, areOnATriangleThatReachesBehindTheEye) {
  Mesh ground;
  for (const glm::dvec3 corner : {glm::dvec3(0, 10, 0), {1000, 10, 0}, {500, 10, 1000}})
    ground.positions.push_back(packPosition(glm::uvec3(corner * 1024.0)));
  ground.triangles = {{0, 1, 2}};
  const CutPart part{kRootKey, 0, true, 0, std::make_shared<const Mesh>(std::move(ground))};
  EXPECT_TRUE(placesOf({part}, lookingAt({500, 100, 400}, {500, 0, 100})).in(kRootKey));
}

TEST(SeenPlaces, areNotComputedForACutWithTooManyTrianglesToDraw) {
  Mesh mesh = *wall(0, 1000, 100).mesh;
  for (int i = 0; i < 14; ++i)
    mesh.triangles.insert(mesh.triangles.end(), mesh.triangles.begin(), mesh.triangles.end());
  Cut cut;
  cut.view = kFromTheFront;
  cut.parts = {{kRootKey, 0, true, 0, std::make_shared<const Mesh>(std::move(mesh))}};
  EXPECT_FALSE(SeenPlaces::of(cut, summary()));
}

TEST(SeenPlaces, coverEachOfManySmallParts) {
  Cut cut;
  cut.view = kFromTheFront;
  for (int i = 0; i < 2000; ++i) cut.parts.push_back(wall(i * 0.5, (i + 1) * 0.5, 100));
  NodeKey small = kRootKey;  // 1/64 of the side, around (512, 256, 100)
  for (const unsigned octant : {1u, 2u, 0u, 4u, 4u, 0u}) small = small.child(octant);
  EXPECT_TRUE(SeenPlaces::of(cut, summary()).value().in(small));
}

TEST(SeenPlaces, areEmptyIfNothingIsDrawn) { EXPECT_FALSE(placesOf({}, kFromTheFront).in(kRootKey)); }

}  // namespace
}  // namespace lode::core
