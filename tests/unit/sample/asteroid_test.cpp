#include "server/sample/asteroid.h"

#include "tests/unit/sample/sample_fixture.h"

namespace lode::ingest {
namespace {

PlyContent asteroid(uint64_t triangles) { return sampleContent(sampleOf("asteroid", triangles)); }

TEST(Asteroid, isAClosedSurfaceOfOneSphere) {
  for (const uint64_t triangles : {12u, 48u, 108u, 5000u}) {
    const PlyContent content = asteroid(triangles);
    const auto edges = directedEdges(content);
    for (const auto& [edge, uses] : edges) {
      EXPECT_EQ(uses, 1);
      EXPECT_TRUE(edges.contains({edge.second, edge.first}));
    }
    const int64_t euler = static_cast<int64_t>(content.vertices.size()) -
                          static_cast<int64_t>(edges.size() / 2) + static_cast<int64_t>(content.faces.size());
    EXPECT_EQ(euler, 2);
  }
}

TEST(Asteroid, hasTheMostTrianglesThatFit) {
  const PlyFolder folder;
  const auto write = [&](uint64_t triangles) {
    return writeSample(sampleOf("asteroid", triangles), folder.path() / "a.ply");
  };
  EXPECT_EQ(write(12), 12u);
  EXPECT_EQ(write(47), 12u);
  EXPECT_EQ(write(48), 48u);
  EXPECT_EQ(write(120'000), 120'000u);
  EXPECT_EQ(readPly(folder.path() / "a.ply").counts.triangles, 120'000u);
}

TEST(Asteroid, facesOutwards) {
  const PlyContent content = asteroid(50'000);
  for (size_t i = 0; i < content.faces.size(); ++i) {
    ASSERT_GT(glm::dot(faceNormal(content, i), content.vertices[content.faces[i][0]].position), 0)
        << "it is a graph over the sphere";
  }
}

TEST(Asteroid, isOfRadiusAboutOne) {
  for (const PlyVertex& vertex : asteroid(20'000).vertices) {
    EXPECT_GT(glm::length(vertex.position), 0.5);
    EXPECT_LT(glm::length(vertex.position), 1.5);
  }
}

TEST(Asteroid, hasReliefDownToItsTriangles) {
  // On a smooth sphere, the angles between neighbouring triangles shrink with the triangles. Relief at every
  // scale prevents this.
  const auto mean_bend = [](uint64_t triangles) {
    const PlyContent content = asteroid(triangles);
    std::map<DirectedEdge, glm::dvec3> normals;
    for (size_t face = 0; face < content.faces.size(); ++face) {
      const auto& corners = content.faces[face];
      for (size_t i = 0; i < 3; ++i) {
        normals[{corners[i], corners[(i + 1) % 3]}] = glm::normalize(faceNormal(content, face));
      }
    }
    double sum = 0;
    for (const auto& [edge, normal] : normals)
      sum += 1 - glm::dot(normal, normals[{edge.second, edge.first}]);
    return sum / static_cast<double>(normals.size());
  };
  EXPECT_GT(mean_bend(300'000), 0.5 * mean_bend(3'000));
}

}  // namespace
}  // namespace lode::ingest
