#include "server/sample/asteroid.h"
#include "server/sample/gyroid.h"
#include "server/sample/terrain.h"
#include "tests/unit/sample/sample_fixture.h"

namespace lode::ingest {
namespace {

ErrorCode codeOf(const SampleOptions& options) {
  try {
    sampleBytes(options);
  } catch (const Error& error) {
    return error.code();
  }
  return ErrorCode::kInternal;
}

class Sample : public testing::TestWithParam<const char*> {};

TEST_P(Sample, hasNormalsOfItsSurfaceOfUnitLength) {
  const PlyContent content = sampleContent(sampleOf(GetParam(), 200'000, AttributeSet::kNormal));
  for (const PlyVertex& vertex : content.vertices) EXPECT_NEAR(glm::length(vertex.normal), 1, 1e-5);
  EXPECT_GT(agreementOfNormals(content), 0.97);
}

TEST_P(Sample, isTheSameForAnyNumberOfThreads) {
  const auto bytes = [](unsigned threads) {
    return sampleBytes(sampleOf(GetParam(), 300'000, kAllOfASample, 5, threads));
  };
  const std::string one = bytes(1);
  EXPECT_EQ(one, bytes(3));
  EXPECT_EQ(one, bytes(0));
}

TEST_P(Sample, isAnotherForAnotherSeed) {
  const auto bytes = [](uint64_t seed) { return sampleBytes(sampleOf(GetParam(), 5000, 0, seed)); };
  EXPECT_EQ(bytes(5), bytes(5));
  EXPECT_NE(bytes(5).substr(300), bytes(6).substr(300));
}

TEST_P(Sample, hasTheRequestedAttributes) {
  for (const int bits : {0, 1, 2, 8, 3, 9, 11}) {
    const auto attributes = static_cast<uint8_t>(bits);
    EXPECT_EQ(sampleContent(sampleOf(GetParam(), 5000, attributes)).attributes.bits, attributes);
  }
}

TEST_P(Sample, hasTextureCoordinatesFromZeroToOne) {
  for (const PlyVertex& vertex : sampleContent(sampleOf(GetParam(), 5000, AttributeSet::kTexture)).vertices) {
    EXPECT_TRUE(glm::all(glm::greaterThanEqual(vertex.texture, decltype(vertex.texture)(0))));
    EXPECT_TRUE(glm::all(glm::lessThanEqual(vertex.texture, decltype(vertex.texture)(1))));
  }
}

TEST_P(Sample, isHardlySmallerThanRequested) {
  const PlyFolder folder;
  for (const uint64_t asked : {50'000u, 100'000u, 250'000u, 1'000'000u}) {
    const uint64_t made = writeSample(sampleOf(GetParam(), asked, 0, 1, 2), folder.path() / "a.ply");
    EXPECT_LE(made, asked);
    EXPECT_GT(static_cast<double>(made), 0.93 * static_cast<double>(asked));
  }
}

TEST_P(Sample, usesEveryVertex) {
  const PlyContent content = sampleContent(sampleOf(GetParam(), 20'000));
  std::vector<bool> used(content.vertices.size());
  for (const auto& face : content.faces) {
    for (const uint64_t corner : face) used[corner] = true;
  }
  EXPECT_TRUE(std::all_of(used.begin(), used.end(), [](bool is) { return is; }));
  EXPECT_EQ(content.counts.dropped_faces, 0u);
}

TEST_P(Sample, refusesCountsThatItCannotMake) {
  EXPECT_EQ(codeOf(sampleOf(GetParam(), 0)), ErrorCode::kUsage);
  EXPECT_EQ(codeOf(sampleOf(GetParam(), 1)), ErrorCode::kUsage);
  EXPECT_EQ(codeOf(sampleOf(GetParam(), 4'000'000'001)), ErrorCode::kUsage);
  EXPECT_EQ(codeOf(sampleOf(GetParam(), ~uint64_t{0})), ErrorCode::kUsage);
}

TEST_P(Sample, refusesAttributesThatItDoesNotHave) {
  EXPECT_EQ(codeOf(sampleOf(GetParam(), 5000, AttributeSet::kMaterial)), ErrorCode::kUsage);
  EXPECT_EQ(codeOf(sampleOf(GetParam(), 5000, AttributeSet::kAlpha)), ErrorCode::kUsage);
}

INSTANTIATE_TEST_SUITE_P(Kinds, Sample, testing::Values("asteroid", "gyroid", "terrain"),
                         [](const auto& kind) { return std::string(kind.param); });

TEST(SampleKinds, areRefusedIfUnknown) {
  EXPECT_EQ(codeOf(sampleOf("teapot", 5000)), ErrorCode::kUsage);
  EXPECT_EQ(codeOf(sampleOf("", 5000)), ErrorCode::kUsage);
}

TEST(SampleKinds, startAtTheirLeastNumberOfTriangles) {
  EXPECT_EQ(makeAsteroid(kLeastAsteroid, 1, {})->triangles(), kLeastAsteroid);
  EXPECT_EQ(makeGyroid(kLeastGyroid, 1, {})->triangles(), kLeastGyroid);
  EXPECT_EQ(makeTerrain(kLeastTerrain, 1, {})->triangles(), kLeastTerrain);
  EXPECT_EQ(codeOf(sampleOf("gyroid", kLeastGyroid - 1)), ErrorCode::kUsage);
}

/// Memory is bounded because blocks are: checks blocks of models of four billion triangles.
TEST(SampleKinds, keepTheirBlocksSmallHoweverLargeTheModelIs) {
  for (const auto make : {makeAsteroid, makeGyroid, makeTerrain}) {
    const auto model = make(4'000'000'000, 1, {kAllOfASample});
    EXPECT_GT(model->triangles(), 3'700'000'000u);
    EXPECT_LT(model->vertices(), uint64_t{1} << 31);
    for (const uint64_t block : {uint64_t{0}, model->blocks() / 2, model->blocks() - 1}) {
      std::vector<SampleVertex> vertices;
      std::vector<glm::u32vec3> triangles;
      model->addVertices(block, vertices);
      model->addTriangles(block, triangles);
      EXPECT_LE(vertices.size(), 2 * RowRange::kBlockRows);
      EXPECT_LE(triangles.size(), 2 * RowRange::kBlockRows);
      for (const glm::u32vec3& triangle : triangles) {
        EXPECT_LT(glm::max(glm::max(triangle.x, triangle.y), triangle.z), model->vertices());
      }
    }
  }
}

}  // namespace
}  // namespace lode::ingest
