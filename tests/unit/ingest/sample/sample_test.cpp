#include "server/ingest/sample/sample.h"

#include <iterator>
#include <map>

#include "tests/unit/ingest/ply/ply_fixture.h"

namespace lode::ingest {
namespace {

std::string sampleBytes(const SampleOptions& options) {
  const PlyFolder folder;
  writeSample(options, folder.path() / "sample.ply");
  std::ifstream file(folder.path() / "sample.ply", std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

SampleOptions asteroid(uint64_t triangles, uint8_t attributes = 0, uint64_t seed = 1, unsigned threads = 1) {
  return {"asteroid", triangles, {attributes}, seed, threads};
}

ErrorCode codeOf(const SampleOptions& options) {
  try {
    sampleBytes(options);
  } catch (const Error& error) {
    return error.code();
  }
  return ErrorCode::kInternal;
}

TEST(Sample, isAClosedSurfaceOfOneSphere) {
  for (const uint64_t triangles : {12u, 48u, 108u, 5000u}) {
    const PlyContent content = readPlyBytes(sampleBytes(asteroid(triangles)));
    std::map<std::pair<uint64_t, uint64_t>, int> edges;
    for (const auto& face : content.faces) {
      for (size_t i = 0; i < 3; ++i) ++edges[{face[i], face[(i + 1) % 3]}];
    }
    for (const auto& [edge, uses] : edges) {
      EXPECT_EQ(uses, 1);
      EXPECT_TRUE(edges.contains({edge.second, edge.first}));
    }
    const int64_t euler = static_cast<int64_t>(content.vertices.size()) -
                          static_cast<int64_t>(edges.size() / 2) + static_cast<int64_t>(content.faces.size());
    EXPECT_EQ(euler, 2);
    EXPECT_EQ(content.counts.dropped_faces, 0u);
  }
}

TEST(Sample, hasTheMostTrianglesThatFit) {
  const PlyFolder folder;
  EXPECT_EQ(writeSample(asteroid(12), folder.path() / "a.ply"), 12u);
  EXPECT_EQ(writeSample(asteroid(47), folder.path() / "a.ply"), 12u);
  EXPECT_EQ(writeSample(asteroid(48), folder.path() / "a.ply"), 48u);
  EXPECT_EQ(writeSample(asteroid(120'000), folder.path() / "a.ply"), 120'000u);
  EXPECT_EQ(readPly(folder.path() / "a.ply").counts.triangles, 120'000u);
}

TEST(Sample, facesOutwards) {
  const PlyContent content = readPlyBytes(sampleBytes(asteroid(50'000, AttributeSet::kNormal)));
  size_t outwards = 0;
  for (const auto& face : content.faces) {
    const glm::dvec3 a = content.vertices[face[0]].position;
    const glm::dvec3 normal =
        glm::cross(content.vertices[face[1]].position - a, content.vertices[face[2]].position - a);
    outwards += glm::dot(normal, a) > 0 ? 1 : 0;
  }
  EXPECT_EQ(outwards, content.faces.size()) << "it is a graph over the sphere";
}

TEST(Sample, normalsAreThoseOfTheSurface) {
  const PlyContent content = readPlyBytes(sampleBytes(asteroid(200'000, AttributeSet::kNormal)));
  std::vector<glm::dvec3> sums(content.vertices.size());
  for (const auto& face : content.faces) {
    const glm::dvec3 a = content.vertices[face[0]].position;
    const glm::dvec3 normal =
        glm::cross(content.vertices[face[1]].position - a, content.vertices[face[2]].position - a);
    for (const uint64_t corner : face) sums[corner] += normal;
  }
  double mean_cosine = 0;
  for (size_t i = 0; i < sums.size(); ++i) {
    EXPECT_NEAR(glm::length(content.vertices[i].normal), 1, 1e-5);
    mean_cosine += glm::dot(glm::normalize(sums[i]), glm::dvec3(content.vertices[i].normal));
  }
  EXPECT_GT(mean_cosine / static_cast<double>(sums.size()), 0.98);
}

TEST(Sample, isOfRadiusAboutOne) {
  for (const PlyVertex& vertex : readPlyBytes(sampleBytes(asteroid(20'000))).vertices) {
    EXPECT_GT(glm::length(vertex.position), 0.5);
    EXPECT_LT(glm::length(vertex.position), 1.5);
  }
}

TEST(Sample, hasReliefDownToItsTriangles) {
  // A sphere of n triangles has dihedral angles that fall as the triangles shrink; relief at every scale
  // keeps them.
  const auto mean_bend = [](uint64_t triangles) {
    const PlyContent content = readPlyBytes(sampleBytes(asteroid(triangles)));
    std::map<std::pair<uint64_t, uint64_t>, glm::dvec3> normals;
    for (const auto& face : content.faces) {
      const glm::dvec3 a = content.vertices[face[0]].position;
      const glm::dvec3 normal = glm::normalize(
          glm::cross(content.vertices[face[1]].position - a, content.vertices[face[2]].position - a));
      for (size_t i = 0; i < 3; ++i) normals[{face[i], face[(i + 1) % 3]}] = normal;
    }
    double sum = 0;
    for (const auto& [edge, normal] : normals)
      sum += 1 - glm::dot(normal, normals[{edge.second, edge.first}]);
    return sum / static_cast<double>(normals.size());
  };
  EXPECT_GT(mean_bend(300'000), 0.5 * mean_bend(3'000));
}

TEST(Sample, isTheSameForAnyNumberOfThreads) {
  const uint8_t all = AttributeSet::kNormal | AttributeSet::kColour | AttributeSet::kTexture;
  const std::string one = sampleBytes(asteroid(300'000, all, 5, 1));
  EXPECT_EQ(one, sampleBytes(asteroid(300'000, all, 5, 3)));
  EXPECT_EQ(one, sampleBytes(asteroid(300'000, all, 5, 0)));
}

TEST(Sample, dependsOnTheSeed) {
  EXPECT_EQ(sampleBytes(asteroid(1000, 0, 5)), sampleBytes(asteroid(1000, 0, 5)));
  EXPECT_NE(sampleBytes(asteroid(1000, 0, 5)).substr(300), sampleBytes(asteroid(1000, 0, 6)).substr(300));
}

TEST(Sample, hasTheAttributesAskedFor) {
  for (const int bits : {0, 1, 2, 8, 3, 9, 11}) {
    const auto attributes = static_cast<uint8_t>(bits);
    EXPECT_EQ(readPlyBytes(sampleBytes(asteroid(500, attributes))).attributes.bits, attributes);
  }
}

TEST(Sample, refusesWhatItCannotMake) {
  EXPECT_EQ(codeOf({"teapot", 100, {}, 1, 1}), ErrorCode::kUsage);
  EXPECT_EQ(codeOf(asteroid(11)), ErrorCode::kUsage);
  EXPECT_EQ(codeOf(asteroid(5'000'000'000)), ErrorCode::kUsage);
  EXPECT_EQ(codeOf(asteroid(100, AttributeSet::kMaterial)), ErrorCode::kUsage);
}

}  // namespace
}  // namespace lode::ingest
