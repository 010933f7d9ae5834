#include "server/sample/gyroid.h"

#include <set>

#include "tests/unit/sample/sample_fixture.h"

namespace lode::ingest {
namespace {

PlyContent gyroid(uint64_t triangles, uint64_t seed = 1) {
  return sampleContent(sampleOf("gyroid", triangles, AttributeSet::kNormal, seed));
}

TEST(Gyroid, isClosedAtEverySize) {
  for (const uint64_t triangles : {2880u, 4500u, 9000u, 20'000u, 60'000u, 300'000u}) {
    const auto edges = directedEdges(gyroid(triangles));
    for (const auto& [edge, uses] : edges) {
      ASSERT_EQ(uses, 1) << triangles;
      ASSERT_TRUE(edges.contains({edge.second, edge.first})) << triangles;
    }
  }
}

/// Expects that triangles around each vertex form one fan, by following the edges opposite to it.
TEST(Gyroid, isManifoldAtEveryVertex) {
  const PlyContent content = gyroid(60'000);
  std::vector<std::map<uint64_t, uint64_t>> around(content.vertices.size());
  for (const auto& face : content.faces) {
    for (size_t i = 0; i < 3; ++i) around[face[i]][face[(i + 1) % 3]] = face[(i + 2) % 3];
  }
  for (const auto& links : around) {
    size_t steps = 0;
    uint64_t at = links.begin()->first;
    do {
      at = links.at(at);
      ++steps;
    } while (at != links.begin()->first && steps <= links.size());
    ASSERT_EQ(steps, links.size());
  }
}

TEST(Gyroid, isOnePieceFullOfHoles) {
  for (const uint64_t triangles : {2880u, 20'000u, 100'000u}) {
    const PlyContent content = gyroid(triangles);
    EXPECT_EQ(piecesOf(content), 1u);
    const auto edges = static_cast<int64_t>(directedEdges(content).size() / 2);
    const int64_t euler =
        static_cast<int64_t>(content.vertices.size()) - edges + static_cast<int64_t>(content.faces.size());
    EXPECT_LE(euler, -16) << "each of at least eight periods has handles";
  }
}

TEST(Gyroid, enclosesAVolumeFromOutside) {
  const PlyContent content = gyroid(100'000);
  double volume = 0;
  for (size_t i = 0; i < content.faces.size(); ++i) {
    volume += glm::dot(content.vertices[content.faces[i][0]].position, faceNormal(content, i)) / 6;
  }
  EXPECT_GT(volume, 0.25 * 8);
  EXPECT_LT(volume, 0.6 * 8);
}

TEST(Gyroid, isMadeOfWellShapedTriangles) {
  const PlyContent content = gyroid(100'000);
  size_t slivers = 0;
  for (size_t i = 0; i < content.faces.size(); ++i) {
    double squares = 0;
    for (size_t k = 0; k < 3; ++k) {
      const glm::dvec3 side = content.vertices[content.faces[i][k]].position -
                              content.vertices[content.faces[i][(k + 1) % 3]].position;
      squares += glm::dot(side, side);
    }
    slivers +=
        2 * std::sqrt(3) * glm::length(faceNormal(content, i)) / squares < 0.2 ? 1 : 0;  // 1: equilateral
  }
  EXPECT_LT(slivers, content.faces.size() / 1000);
}

/// Blocks grow so that no axis is more than one cell longer than another.
TEST(Gyroid, hasAboutEqualSides) {
  for (const uint64_t triangles : {50'000u, 100'000u, 200'000u, 400'000u}) {
    glm::dvec3 low(1e9), high(-1e9);
    for (const PlyVertex& vertex : gyroid(triangles).vertices) {
      low = glm::min(low, vertex.position);
      high = glm::max(high, vertex.position);
    }
    const glm::dvec3 size = high - low;
    EXPECT_GT(std::min({size.x, size.y, size.z}), 0.55 * std::max({size.x, size.y, size.z}));
    EXPECT_NEAR(std::max({size.x, size.y, size.z}), 2, 0.4);
  }
}

}  // namespace
}  // namespace lode::ingest
