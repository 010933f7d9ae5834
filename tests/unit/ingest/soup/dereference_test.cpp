#include "server/ingest/soup/dereference.h"

#include <cmath>
#include <random>
#include <tuple>

#include <gtest/gtest.h>

namespace lode::ingest {
namespace {

/// Adds random faces of 3 to 5 corners over random vertices with colours, in several blocks.
void fill(PackedInput& input) {
  std::mt19937 random(3);
  constexpr uint32_t kVertices = 200'000;  // enough for several sweeps
  std::vector<PlyVertex> vertices;
  for (uint32_t v = 0; v < kVertices; ++v) {
    const double off = v < kVertices / 100 ? 0.25 : 0;  // needs a finer lattice
    vertices.push_back(
        {.position = {static_cast<double>(random() % 1000) + off, random() % 1000, random() % 1000},
         .colour = {static_cast<uint8_t>(v), static_cast<uint8_t>(v >> 8), 7, 255}});
  }
  input.addVertices(vertices);
  for (int block = 0; block < 20; ++block) {
    PlyFaces faces;
    for (int f = 0; f < 100; ++f) {
      const uint32_t corners = block % 3 == 0 ? 3 : 3 + static_cast<uint32_t>(random() % 3);
      faces.corner_counts.push_back(corners);
      const uint64_t first = random() % (kVertices - 8);
      for (uint32_t c = 0; c < corners; ++c) faces.corners.push_back(first + c);
    }
    input.addFaces(faces);
  }
  input.flush();
}

std::vector<SoupTriangle> run(const PackedInput& input, uint64_t memory_bytes, DereferenceCounts& counts,
                              unsigned threads = 1) {
  std::vector<SoupTriangle> soup;
  counts = dereference({.input = input, .lattice = {}, .memory_bytes = memory_bytes, .threads = threads},
                       [&](std::span<const SoupTriangle> triangles) {
                         soup.insert(soup.end(), triangles.begin(), triangles.end());
                       });
  return soup;
}

class DereferenceWith : public testing::TestWithParam<std::tuple<uint64_t, unsigned>> {};

/// Test parameters: memory and threads.
TEST_P(DereferenceWith, givesTheSameTrianglesInTheSameOrderAsOneThread) {
  const auto [memory_bytes, threads] = GetParam();
  const TemporaryFolder folder(testing::TempDir());
  PackedInput input(folder, AttributeSet{AttributeSet::kColour}, false);
  fill(input);
  DereferenceCounts at_once, in_batches;
  const auto whole = run(input, 1 << 30, at_once);
  const auto parts = run(input, memory_bytes, in_batches, threads);
  ASSERT_EQ(whole.size(), parts.size());
  EXPECT_EQ(at_once.triangles, whole.size());
  EXPECT_EQ(in_batches.triangles, whole.size());
  EXPECT_EQ(at_once.dropped, in_batches.dropped);
  EXPECT_EQ(at_once.snap_error_steps, in_batches.snap_error_steps);
  EXPECT_GT(at_once.snap_error_steps, 0);
  for (size_t t = 0; t < whole.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      ASSERT_EQ(whole[t].corners[k], parts[t].corners[k]);
      ASSERT_EQ(whole[t].attributes[k], parts[t].attributes[k]);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(MemoryAndThreads, DereferenceWith,
                         testing::Combine(testing::Values(uint64_t{1}, uint64_t{1} << 30),
                                          testing::Values(1u, 4u)));

TEST(Dereference, dropsAndCountsTrianglesWhoseCornersCoincideOnTheLattice) {
  const TemporaryFolder folder(testing::TempDir());
  PackedInput input(folder, AttributeSet{}, true);
  const std::vector<PlyVertex> vertices{
      {.position = {0, 0, 0}}, {.position = {0.3, 0, 0}}, {.position = {5, 0, 0}}, {.position = {0, 5, 0}}};
  input.addVertices(vertices);
  PlyFaces faces;
  faces.corner_counts = {3, 3};
  faces.corners = {0, 1, 2, 0, 2, 3};
  input.addFaces(faces);
  input.flush();
  DereferenceCounts counts;
  EXPECT_EQ(run(input, 1 << 20, counts).size(), 1u);
  EXPECT_EQ(counts.triangles, 1u);
  EXPECT_EQ(counts.dropped, 1u);
}

TEST(Dereference, distinguishesTrianglesLostByTheLatticeFromFlatOnes) {
  const TemporaryFolder folder(testing::TempDir());
  PackedInput input(folder, AttributeSet{}, false);
  const std::vector<PlyVertex> vertices{
      {.position = {0, 0, 0}}, {.position = {0.3, 0, 0}}, {.position = {5, 0, 0}}, {.position = {0, 0, 0}}};
  input.addVertices(vertices);
  PlyFaces faces;
  faces.corner_counts = {3, 3, 3};
  faces.corners = {0, 1, 2, 0, 3, 2, 0, 0, 2};
  input.addFaces(faces);
  input.flush();
  DereferenceCounts counts;
  run(input, 1 << 20, counts);
  EXPECT_EQ(counts.dropped, 3u);
  EXPECT_EQ(counts.lost, 1u);
}

TEST(Dereference, reportsHowFarItMovedUsedVertices) {
  const TemporaryFolder folder(testing::TempDir());
  PackedInput input(folder, AttributeSet{}, true);
  const std::vector<PlyVertex> vertices{{.position = {0, 0, 0}},
                                        {.position = {7.25, 0, 0.125}},
                                        {.position = {0, 5, 0}},
                                        {.position = {0.5, 0.5, 0.5}}};
  input.addVertices(vertices);
  PlyFaces faces;
  faces.corner_counts = {3};
  faces.corners = {0, 1, 2};
  input.addFaces(faces);
  input.flush();
  DereferenceCounts counts;
  run(input, 1 << 20, counts);
  EXPECT_DOUBLE_EQ(counts.snap_error_steps, std::hypot(0.25, 0.125));
}

/// Adds a quad and a triangle over five vertices.
struct TwoFaces {
  std::vector<PlyVertex> vertices{{.position = {0, 0, 0}, .texture = {0, 0}},
                                  {.position = {10, 0, 0}, .texture = {1.25, 0}},
                                  {.position = {10, 10, 0}, .texture = {1.25, 0.5}},
                                  {.position = {0, 10, 0}, .texture = {0, 0.5}},
                                  {.position = {5, 20, 0}, .texture = {-0.5, 0.25}}};
  PlyFaces faces{.corner_counts = {4, 3}, .corners = {0, 1, 2, 3, 3, 2, 4}, .texture = {}, .materials = {}};
};

glm::dvec2 uvOf(const PackedInput& input, const VertexAttributes& attributes) {
  return input.uvGrid().origin +
         glm::dvec2(attributes.texture) * std::ldexp(1.0, input.uvGrid().scale_exponent - 16);
}

TEST(Dereference, givesEachCornerTheTextureCoordinatesOfItsVertex) {
  const TemporaryFolder folder(testing::TempDir());
  PackedInput input(folder, AttributeSet{AttributeSet::kTexture | AttributeSet::kColour}, false);
  const TwoFaces model;
  input.addVertices(model.vertices);
  input.addFaces(model.faces);
  input.flush();
  input.setUvGrid(chooseUvGrid(input.uvRange(), "a.ply"));
  DereferenceCounts counts;
  const auto soup = run(input, 1 << 20, counts);
  ASSERT_EQ(soup.size(), 3u);
  for (const SoupTriangle& triangle : soup)
    for (int k = 0; k < 3; ++k)
      for (const PlyVertex& vertex : model.vertices)
        if (packPosition(Lattice{}.snap(vertex.position)) == triangle.corners[k]) {
          EXPECT_EQ(uvOf(input, triangle.attributes[k]), glm::dvec2(vertex.texture));
        }
}

TEST(Dereference, givesEachCornerItsOwnTextureCoordinatesAndItsFacesMaterial) {
  const TemporaryFolder folder(testing::TempDir());
  PackedInput input(folder, AttributeSet{AttributeSet::kTexture | AttributeSet::kMaterial}, false,
                    AttributeSet{AttributeSet::kTexture | AttributeSet::kMaterial});
  TwoFaces model;
  for (uint32_t c = 0; c < 7; ++c) model.faces.texture.emplace_back(-0.125f * static_cast<float>(c), 0.5f);
  model.faces.materials = {3, kNoMaterial};
  input.addVertices(model.vertices);
  input.addFaces(model.faces);
  input.flush();
  input.setUvGrid(chooseUvGrid(input.uvRange(), "a.ply"));
  DereferenceCounts counts;
  const auto soup = run(input, 1 << 20, counts);
  ASSERT_EQ(soup.size(), 3u);
  for (size_t t = 0; t < 3; ++t)
    for (int k = 0; k < 3; ++k) {
      const VertexAttributes& attributes = soup[t].attributes[k];
      EXPECT_EQ(attributes.material, t < 2 ? 3 : kNoMaterial);
      const size_t first = t < 2 ? 0 : 4, end = t < 2 ? 4 : 7;
      bool found = false;
      for (size_t c = first; c < end; ++c)
        found = found || (packPosition(Lattice{}.snap(model.vertices[model.faces.corners[c]].position)) ==
                              soup[t].corners[k] &&
                          uvOf(input, attributes) == glm::dvec2(model.faces.texture[c]));
      EXPECT_TRUE(found) << t << " " << k;
    }
}

TEST(Dereference, givesEachTriangleOfAPolygonTheColourOfItsFace) {
  const TemporaryFolder folder(testing::TempDir());
  const AttributeSet colours{AttributeSet::kColour | AttributeSet::kAlpha};
  PackedInput input(folder, colours, false, colours);
  TwoFaces model;
  model.faces.colours = {{200, 100, 50, 25}, {1, 2, 3, 4}};
  input.addVertices(model.vertices);
  input.addFaces(model.faces);
  input.flush();
  EXPECT_FALSE(input.hasVertexAttributes());
  DereferenceCounts counts;
  const auto soup = run(input, 1 << 20, counts);
  ASSERT_EQ(soup.size(), 3u);
  for (size_t t = 0; t < 3; ++t)
    for (const VertexAttributes& attributes : soup[t].attributes)
      EXPECT_EQ(attributes.colour, model.faces.colours[t < 2 ? 0 : 1]) << t;
}

}  // namespace
}  // namespace lode::ingest
