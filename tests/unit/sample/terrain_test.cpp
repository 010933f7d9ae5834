#include "server/sample/terrain.h"

#include <set>

#include "tests/unit/sample/sample_fixture.h"

namespace lode::ingest {
namespace {

PlyContent terrain(uint64_t triangles, uint8_t attributes = 0, uint64_t seed = 1) {
  return sampleContent(sampleOf("terrain", triangles, attributes, seed));
}

TEST(Terrain, hasOneBoundaryAndNoOtherOpenEdge) {
  for (const uint64_t triangles : {2u, 4u, 8u, 5000u, 100'000u}) {
    const auto edges = directedEdges(terrain(triangles));
    std::map<uint64_t, uint64_t> boundary;
    for (const auto& [edge, uses] : edges) {
      ASSERT_EQ(uses, 1);
      if (edges.contains({edge.second, edge.first})) continue;
      ASSERT_TRUE(boundary.emplace(edge.first, edge.second).second) << "the boundary touches itself";
    }
    size_t steps = 0;
    uint64_t at = boundary.begin()->first;
    do {
      at = boundary.at(at);
      ++steps;
    } while (at != boundary.begin()->first && steps <= boundary.size());
    EXPECT_EQ(steps, boundary.size()) << "there is more than one boundary";
  }
}

TEST(Terrain, hasTheMostTrianglesThatFit) {
  const PlyFolder folder;
  const auto write = [&](uint64_t triangles) {
    return writeSample(sampleOf("terrain", triangles), folder.path() / "a.ply");
  };
  EXPECT_EQ(write(2), 2u);
  EXPECT_EQ(write(4), 4u);
  EXPECT_EQ(write(7), 4u);
  EXPECT_EQ(write(8), 8u);
  EXPECT_EQ(write(20'000), 20'000u);
}

TEST(Terrain, hasOverhangs) {
  for (const uint64_t seed : {1u, 2u, 3u}) {
    const PlyContent content = terrain(100'000, 0, seed);
    size_t down = 0;
    for (size_t i = 0; i < content.faces.size(); ++i) down += faceNormal(content, i).z < 0 ? 1 : 0;
    EXPECT_GT(down, content.faces.size() / 500);
    EXPECT_LT(down, content.faces.size() / 4) << "most of it can be walked on";
  }
}

TEST(Terrain, isAboutTwoWideAndLessThanOneHigh) {
  for (const PlyVertex& vertex : terrain(20'000).vertices) {
    EXPECT_LT(std::abs(vertex.position.x), 1.1);
    EXPECT_LT(std::abs(vertex.position.y), 1.1);
    EXPECT_GE(vertex.position.z, 0);
    EXPECT_LT(vertex.position.z, 1);
  }
}

TEST(Terrain, isPaintedByHeightAndSlope) {
  const PlyContent content = terrain(200'000, AttributeSet::kNormal | AttributeSet::kColour, 2);
  size_t lake = 0, blue = 0, snow = 0, white = 0;
  for (const PlyVertex& vertex : content.vertices) {
    const glm::ivec3 colour(vertex.colour);
    if (vertex.position.z < 0.0201) {
      ++lake;
      blue += colour.b > colour.r ? 1 : 0;
    }
    if (vertex.position.z > 0.6 && vertex.normal.z > 0.95f) {
      ++snow;
      white += std::min({colour.r, colour.g, colour.b}) > 170 ? 1 : 0;
    }
  }
  EXPECT_GT(lake, 0u);
  EXPECT_EQ(blue, lake);
  EXPECT_GT(snow, 0u);
  EXPECT_EQ(white, snow);
}

}  // namespace
}  // namespace lode::ingest
