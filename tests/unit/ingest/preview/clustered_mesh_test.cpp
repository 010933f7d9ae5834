#include "server/ingest/preview/clustered_mesh.h"

#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "common/codec/octahedral.h"
#include "server/ingest/measure/triangle_tree.h"

namespace lode::ingest {
namespace {

constexpr uint32_t kExtent = 100'000;  ///< lattice coordinates of the shapes are at most this
constexpr Lattice kLattice;

/// Vertices and triangles of an input, in lattice steps.
struct Shape {
  std::vector<PlyVertex> vertices;
  PlyFaces faces;

  uint64_t addVertex(glm::dvec3 position, glm::u8vec4 colour = glm::u8vec4(255)) {
    vertices.push_back(
        {.position = glm::clamp(glm::round(position), 0.0, double(kExtent)), .colour = colour});
    return vertices.size() - 1;
  }
  void addFace(std::initializer_list<uint64_t> corners) {
    faces.corner_counts.push_back(static_cast<uint32_t>(corners.size()));
    faces.corners.insert(faces.corners.end(), corners);
  }
  void addTriangle(glm::dvec3 a, glm::dvec3 b, glm::dvec3 c) {
    const uint64_t first = addVertex(a);
    addVertex(b);
    addVertex(c);
    addFace({first, first + 1, first + 2});
  }
  void addGrid(uint32_t across, const std::function<glm::dvec3(double, double)>& at, bool has_quads = false) {
    const uint64_t first = vertices.size();
    for (uint32_t i = 0; i <= across; ++i)
      for (uint32_t k = 0; k <= across; ++k) addVertex(at(double(i) / across, double(k) / across));
    for (uint64_t i = 0; i < across; ++i)
      for (uint64_t k = 0; k < across; ++k) {
        const uint64_t a = first + i * (across + 1) + k, b = a + across + 1;
        if (has_quads) {
          addFace({a, b, b + 1, a + 1});
        } else {
          addFace({a, b, b + 1});
          addFace({a, b + 1, a + 1});
        }
      }
  }
};

glm::dvec3 randomPoint(std::mt19937& random) {
  std::uniform_real_distribution<double> in(0, kExtent);
  return {in(random), in(random), in(random)};
}

Shape bumpySphere(uint32_t seed) {
  Shape shape;
  shape.addGrid(150, [seed](double u, double v) {
    const double phi = 2 * std::numbers::pi * u, theta = std::numbers::pi * v;
    const double radius = 0.4 * kExtent * (1 + 0.1 * std::sin(7 * phi + seed) * std::sin(5 * theta));
    return 0.5 * kExtent + radius * glm::dvec3(std::cos(phi) * std::sin(theta),
                                               std::sin(phi) * std::sin(theta), std::cos(theta));
  });
  return shape;
}

Shape sheetOfQuads(uint32_t seed) {
  Shape shape;
  shape.addGrid(
      120,
      [seed](double u, double v) {
        return glm::dvec3(u, v, 0.5 + 0.1 * std::sin(9 * u + seed) * std::cos(8 * v)) * double(kExtent);
      },
      true);
  return shape;
}

/// Triangles that are much longer than a cell and thinner than one.
Shape needles(uint32_t seed) {
  std::mt19937 random(seed);
  Shape shape;
  for (int i = 0; i < 3000; ++i) {
    const glm::dvec3 a = randomPoint(random), b = randomPoint(random);
    shape.addTriangle(a, b, b + glm::dvec3(7, 3, 5));
  }
  return shape;
}

/// Pieces that are smaller than a cell.
Shape confetti(uint32_t seed) {
  std::mt19937 random(seed);
  Shape shape;
  for (int i = 0; i < 5000; ++i) {
    const glm::dvec3 a = randomPoint(random);
    shape.addTriangle(a, a + glm::dvec3(9, 0, 4), a + glm::dvec3(0, 8, 1));
  }
  return shape;
}

Shape largeTriangles(uint32_t seed) {
  std::mt19937 random(seed);
  Shape shape;
  for (int i = 0; i < 4000; ++i) {
    const glm::dvec3 a = randomPoint(random), b = randomPoint(random), c = randomPoint(random);
    shape.addTriangle(a, b, c);
  }
  return shape;
}

/// Long triangles without an area, which a build keeps.
Shape collinear(uint32_t seed) {
  std::mt19937 random(seed);
  Shape shape;
  for (int i = 0; i < 500; ++i) {
    const glm::dvec3 a = glm::round(0.5 * randomPoint(random)), step = glm::round(0.2 * randomPoint(random));
    shape.addTriangle(a, a + step, a + 2.0 * step);
  }
  return shape;
}

struct Kind {
  const char* name;
  Shape (*make)(uint32_t seed);
};

class Clustered : public testing::TestWithParam<std::tuple<Kind, uint32_t>> {
 protected:
  static constexpr ClusterLimits kLimits{.cells = 2000, .triangles = 3000};

  static ClusteredMesh cluster(const Shape& shape, AttributeSet attributes = {},
                               ClusterLimits limits = kLimits) {
    const TemporaryFolder folder(testing::TempDir());
    PackedInput input(folder, attributes, false);
    input.addVertices(shape.vertices);
    input.addFaces(shape.faces);
    input.flush();
    return clusterInput(input, kLattice, glm::uvec3(kExtent), {}, limits);
  }
  Shape shape() const { return std::get<0>(GetParam()).make(std::get<1>(GetParam())); }
};

NodeMesh withTriangles(std::vector<PositionCode> positions, std::vector<glm::u32vec3> triangles) {
  NodeMesh mesh;
  mesh.positions = std::move(positions);
  for (uint32_t i = 0; i < mesh.positions.size(); ++i) mesh.wedge_position.push_back(i);
  mesh.triangles = std::move(triangles);
  return mesh;
}

/// Returns the triangles of a shape. Quads of a shape are nearly flat.
NodeMesh meshOf(const Shape& shape) {
  std::vector<PositionCode> positions;
  for (const PlyVertex& vertex : shape.vertices)
    positions.push_back(packPosition(glm::uvec3(vertex.position)));
  std::vector<glm::u32vec3> triangles;
  size_t first = 0;
  for (const uint32_t corners : shape.faces.corner_counts) {
    for (uint32_t c = 2; c < corners; ++c)
      triangles.emplace_back(shape.faces.corners[first], shape.faces.corners[first + c - 1],
                             shape.faces.corners[first + c]);
    first += corners;
  }
  return withTriangles(std::move(positions), std::move(triangles));
}

/// Returns the largest distance from points of one mesh to another mesh.
float farthest(const NodeMesh& from, const NodeMesh& to) {
  constexpr int kSteps = 6;
  const TriangleTree tree(to);
  float most = 0;
  for (const glm::u32vec3& t : from.triangles) {
    const glm::vec3 a(unpackPosition(from.positions[t.x])), b(unpackPosition(from.positions[t.y])),
        c(unpackPosition(from.positions[t.z]));
    for (int i = 0; i <= kSteps; ++i)
      for (int k = 0; i + k <= kSteps; ++k)
        most =
            std::max(most, tree.distance(a + (b - a) * (float(i) / kSteps) + (c - a) * (float(k) / kSteps)));
  }
  return most;
}

TEST_P(Clustered, liesWithinItsErrorOfTheInputAndTheInputOfIt) {
  const ClusteredMesh clustered = cluster(shape());
  const NodeMesh input = meshOf(shape()),
                 mesh = withTriangles(clustered.mesh.positions, clustered.mesh.triangles);
  EXPECT_LE(farthest(input, mesh), clustered.errorSteps() * 1.001);
  EXPECT_LE(farthest(mesh, input), clustered.errorSteps() * 1.001);
  EXPECT_LT(clustered.errorSteps(), kExtent);
}

TEST_P(Clustered, keepsItsLimits) {
  const Mesh mesh = cluster(shape()).mesh;
  EXPECT_GT(mesh.triangles.size(), 0u);
  EXPECT_LE(mesh.triangles.size(), kLimits.triangles);
}

INSTANTIATE_TEST_SUITE_P(
    Shapes, Clustered,
    testing::Combine(testing::Values(Kind{"bumpySphere", bumpySphere}, Kind{"sheetOfQuads", sheetOfQuads},
                                     Kind{"needles", needles}, Kind{"confetti", confetti},
                                     Kind{"collinear", collinear}, Kind{"largeTriangles", largeTriangles}),
                     testing::Values(1u, 2u)),
    [](const auto& shown) {
      return std::string(std::get<0>(shown.param).name) + std::to_string(std::get<1>(shown.param));
    });

class ClusteredInput : public Clustered {};

TEST_F(ClusteredInput, isExactIfEveryVertexHasItsOwnCell) {
  const Shape shape = bumpySphere(3);
  const ClusteredMesh clustered = cluster(shape, {}, {.cells = 100'000, .triangles = 100'000});
  EXPECT_EQ(clustered.cell_steps, 1u);
  EXPECT_LT(farthest(meshOf(shape), withTriangles(clustered.mesh.positions, clustered.mesh.triangles)), 0.1);
}

TEST_F(ClusteredInput, hasTheMeanColourOfEachCell) {
  Shape shape;
  for (const uint8_t grey : {uint8_t{10}, uint8_t{30}}) {
    const uint64_t first = shape.addVertex({0, 0, grey}, glm::u8vec4(grey, grey, grey, 255));
    shape.addVertex({kExtent, 0, grey}, glm::u8vec4(100, 0, 0, 255));
    shape.addVertex({0, kExtent, grey}, glm::u8vec4(0, 100, 0, 255));
    shape.addFace({first, first + 1, first + 2});
  }
  const Mesh mesh = cluster(shape, AttributeSet{AttributeSet::kColour}, {.cells = 3, .triangles = 10}).mesh;
  ASSERT_EQ(mesh.triangles.size(), 1u);
  ASSERT_EQ(mesh.positions.size(), 3u);
  EXPECT_EQ(mesh.vertex_attributes[0].colour, glm::u8vec4(20, 20, 20, 255));
  EXPECT_EQ(mesh.vertex_attributes[1].colour, glm::u8vec4(100, 0, 0, 255));
}

TEST_F(ClusteredInput, hasTheColoursOfFacesOnlyIfFacesHaveThem) {
  Shape shape;
  const uint64_t first = shape.addVertex({0, 0, 0});
  shape.addVertex({kExtent, 0, 0});
  shape.addVertex({0, kExtent, 0});
  shape.addFace({first, first + 1, first + 2});
  shape.faces.colours = {glm::u8vec4(40, 50, 60, 255)};
  const TemporaryFolder folder(testing::TempDir());
  PackedInput input(folder, AttributeSet{AttributeSet::kColour | AttributeSet::kNormal}, false,
                    AttributeSet{AttributeSet::kColour});
  input.addVertices(shape.vertices);
  input.addFaces(shape.faces);
  input.flush();
  const Mesh mesh = clusterInput(input, kLattice, glm::uvec3(kExtent)).mesh;
  ASSERT_EQ(mesh.positions.size(), 3u);
  for (const VertexAttributes& attributes : mesh.vertex_attributes)
    EXPECT_EQ(attributes.colour, glm::u8vec4(40, 50, 60, 255));
}

TEST_F(ClusteredInput, hasNormalsOfItsTrianglesIfTheInputHasNone) {
  Shape shape;
  shape.addGrid(100, [](double u, double v) { return glm::dvec3(u, v, 0.25) * double(kExtent); });
  const Mesh mesh = cluster(shape).mesh;
  EXPECT_TRUE(mesh.attributes.has(AttributeSet::kComputedNormal));
  for (const VertexAttributes& attributes : mesh.vertex_attributes)
    EXPECT_EQ(decodeOctahedral(attributes.normal), glm::vec3(0, 0, 1));
}

}  // namespace
}  // namespace lode::ingest
