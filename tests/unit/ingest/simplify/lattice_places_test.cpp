#include "server/ingest/simplify/lattice_places.h"

#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "common/codec/draco_codec.h"
#include "server/ingest/mesh/mesh_welder.h"
#include "server/ingest/simplify/collapse.h"
#include "tests/support/node_meshes.h"

namespace lode::ingest {
namespace {

constexpr glm::dvec3 kFarU{-1000}, kFarV{-2000};  // ends of an edge that do not matter

/// A flat square of two triangles, 1024 steps wide.
NodeMesh square() {
  Mesh mesh;
  for (const glm::uvec3 p : {glm::uvec3(0, 0, 0), {1024, 0, 0}, {1024, 1024, 0}, {0, 1024, 0}})
    mesh.positions.push_back(packPosition(p));
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return test::nodeOf(mesh);
}

struct PlacesOfSquare {
  CollapseMesh mesh{square(), 0};
  LatticePlaces places{mesh, glm::dvec3(1024)};

  /// Lattice point chosen for `wanted`.
  glm::dvec3 settle(glm::dvec3 wanted, double off) {
    Quadric q;
    q.addPoint(wanted - mesh.origin, 1);
    return places.settle(wanted - mesh.origin, q, off, kFarU, kFarV) + mesh.origin;
  }
};

bool isMultipleOf(glm::dvec3 place, double step) { return glm::floor(place / step) * step == place; }

TEST(LatticePlaces, areTheNearestLatticePointsAtFullPrecision) {
  PlacesOfSquare p;
  EXPECT_EQ(p.settle({100.3, 77.6, 3.2}, 1e9), glm::dvec3(100, 78, 3));
}

TEST(LatticePlaces, areFurtherApartForLongerEdges) {
  PlacesOfSquare p;
  p.places.aimFor(8);  // edges of about 550 steps
  EXPECT_TRUE(isMultipleOf(p.settle({100.3, 77.6, 3.2}, 1e9), 16));
  EXPECT_FALSE(isMultipleOf(p.settle({100.3, 77.6, 3.2}, 1e9), 32));
  EXPECT_EQ(p.settle({100.3, 77.6, 3.2}, 1e9), glm::dvec3(96, 80, 0));
}

TEST(LatticePlaces, stayWithinTheToleranceOfTheSurface) {
  PlacesOfSquare p;
  p.places.aimFor(8);
  EXPECT_EQ(p.settle({100.3, 77.6, 3.2}, 0.1), glm::dvec3(100, 78, 3));
  EXPECT_EQ(p.settle({100.3, 77.6, 3.2}, 1.1), glm::dvec3(100, 78, 4));
}

TEST(LatticePlaces, areNotTakenTwice) {
  PlacesOfSquare p;
  p.places.take(glm::dvec3(100, 78, 3) - p.mesh.origin);
  EXPECT_NE(p.settle({100.3, 77.6, 3.2}, 0), glm::dvec3(100, 78, 3));
}

TEST(LatticePlaces, stayInTheBox) {
  PlacesOfSquare p;
  p.places.aimFor(2);
  const glm::dvec3 place = p.settle({1023.5, 1023.5, -0.5}, 1e9);
  EXPECT_TRUE(glm::all(glm::greaterThanEqual(place, glm::dvec3(0))) &&
              glm::all(glm::lessThanEqual(place, glm::dvec3(1024))));
}

// A rough sphere with edges of 200 steps initially.
TEST(LatticePlaces, makePayloadsSmallerIfCoarser) {
  const NodeMesh sphere =
      test::nodeOf(test::makeSphere(120, 80, {.attributes = {}, .extent = 1 << 14, .seed = 3, .bump = 0.02}));
  collapse(sphere, std::array<size_t, 1>{1200}, {.node_depth = 0, .max_position = glm::uvec3(kMaxLattice)},
           [&](size_t, SimplifiedMesh&& lod) {
             Mesh mesh = toMesh(lod.mesh), shaken = mesh;
             for (PositionCode& code : shaken.positions) {
               const glm::uvec3 p = unpackPosition(code);
               code =
                   packPosition(p + glm::uvec3(code.value * 2654435761u >> 29 & 7,
                                               code.value * 40503u >> 20 & 7, code.value * 69069u >> 25 & 7));
             }
             EXPECT_LT(static_cast<double>(encodePayload(mesh, 1).bytes.size()),
                       0.9 * static_cast<double>(encodePayload(shaken, 1).bytes.size()));
           });
}

}  // namespace
}  // namespace lode::ingest
