#include "common/codec/surface_normals.h"

#include <random>

#include <gtest/gtest.h>

#include "common/codec/draco_codec.h"
#include "common/codec/octahedral.h"
#include "common/error.h"
#include "tests/support/test_meshes.h"
#include "tests/unit/common/payload_fixture.h"

namespace lode {
namespace {

constexpr double kUnevenStep = 0x1.8p-6;
constexpr uint8_t kComputed = AttributeSet::kNormal | AttributeSet::kComputedNormal;

/// Makes a sphere with the normals of surfaceNormals().
Mesh sphereWithItsNormals(uint8_t attributes = kComputed) {
  Mesh mesh = test::makeSphere(30, 20, {.attributes = {attributes}});
  const std::vector<uint16_t> surface = surfaceNormals(mesh);
  for (size_t v = 0; v < surface.size(); ++v) mesh.vertex_attributes[v].normal = surface[v];
  return mesh;
}

Mesh decode(const Mesh& mesh, const EncodedPayload& payload) {
  return decodePayload(payload.bytes, kUnevenStep, expectationOf(mesh, payload));
}

/// Returns the distinct pairs of position and normal, sorted.
std::vector<std::pair<PositionCode, uint16_t>> normalsOf(const Mesh& mesh) {
  std::vector<std::pair<PositionCode, uint16_t>> normals;
  for (size_t v = 0; v < mesh.positions.size(); ++v)
    normals.emplace_back(mesh.positions[v], mesh.vertex_attributes[v].normal);
  std::ranges::sort(normals);
  const auto twice = std::ranges::unique(normals);
  normals.erase(twice.begin(), twice.end());
  return normals;
}

/// Returns the size of a mesh's normals in its payload.
size_t bytesOfNormals(const Mesh& mesh) {
  Mesh bare = mesh;
  bare.attributes.bits &= static_cast<uint8_t>(~kComputed);
  if (bare.attributes.bits == 0) bare.vertex_attributes.clear();
  return encodePayload(mesh, kUnevenStep).bytes.size() - encodePayload(bare, kUnevenStep).bytes.size();
}

TEST(SurfaceNormals, areWeighedByTheAreasOfTriangles) {
  Mesh mesh;
  for (const glm::uvec3 p : {glm::uvec3(0, 0, 0), {10, 0, 0}, {0, 10, 0}, {0, 0, 30}})
    mesh.positions.push_back(packPosition(p));
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  EXPECT_EQ(surfaceNormals(mesh)[0], encodeOctahedral({300, 0, 100}));
  EXPECT_EQ(surfaceNormals(mesh)[1], encodeOctahedral({0, 0, 1}));
}

TEST(SurfaceNormals, pointUpAtAVertexWithoutTriangles) {
  Mesh mesh;
  mesh.positions.resize(1);
  EXPECT_EQ(surfaceNormals(mesh).at(0), encodeOctahedral({0, 0, 1}));
}

TEST(SurfaceNormals, takeNoBytesIfComputed) {
  const Mesh with = sphereWithItsNormals();
  Mesh without = with;
  without.attributes.bits = 0;
  without.vertex_attributes.clear();
  const EncodedPayload payload = encodePayload(with, kUnevenStep);
  EXPECT_EQ(payload.bytes, encodePayload(without, kUnevenStep).bytes);
  EXPECT_EQ(normalsOf(decode(with, payload)), normalsOf(with));
}

TEST(SurfaceNormals, areStoredIfTheyAreTheFiles) {
  const Mesh computed = sphereWithItsNormals(), given = sphereWithItsNormals(AttributeSet::kNormal);
  EXPECT_GT(encodePayload(given, kUnevenStep).bytes.size(),
            encodePayload(computed, kUnevenStep).bytes.size());
}

TEST(SurfaceNormals, decodeExactlyWhereSomeDiffer) {
  std::mt19937 random(3);
  for (const bool is_far : {false, true}) {
    Mesh mesh = sphereWithItsNormals();
    for (size_t v = 0; v < mesh.positions.size(); v += 1 + random() % 40) {
      const glm::vec3 normal = decodeOctahedral(mesh.vertex_attributes[v].normal);
      const glm::vec3 other = is_far ? glm::vec3(normal.y, -normal.z, normal.x) : normal + glm::vec3(0.04f);
      mesh.vertex_attributes[v].normal = encodeOctahedral(other);
    }
    const EncodedPayload payload = encodePayload(mesh, kUnevenStep);
    EXPECT_EQ(normalsOf(decode(mesh, payload)), normalsOf(mesh));
    Mesh with_all = mesh;
    with_all.attributes.bits = AttributeSet::kNormal;
    EXPECT_LT(payload.bytes.size(), encodePayload(with_all, kUnevenStep).bytes.size());
  }
}

/// A fold at which each side has its own vertices.
TEST(SurfaceNormals, differOnBothSidesOfACrease) {
  Mesh mesh;
  mesh.attributes.bits = kComputed;
  for (const glm::uvec3 p : {glm::uvec3(0, 0, 0),
                             {0, 90, 0},
                             {90, 0, 90},
                             {90, 90, 90},
                             {90, 0, 90},
                             {90, 90, 90},
                             {180, 0, 0},
                             {180, 90, 0}})
    mesh.positions.push_back(packPosition(p));
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 6, 7}, {4, 7, 5}};
  for (const float x : {-1.f, 1.f})
    mesh.vertex_attributes.insert(mesh.vertex_attributes.end(), 4,
                                  {.normal = encodeOctahedral({x, 0, 1}), .material = 0});
  EXPECT_EQ(normalsOf(decode(mesh, encodePayload(mesh, kUnevenStep))), normalsOf(mesh));
  EXPECT_EQ(bytesOfNormals(mesh), 0);
}

/// Two fans share a vertex and its normal; Draco splits the vertex.
TEST(SurfaceNormals, surviveDracosSplitOfAVertex) {
  Mesh mesh;
  mesh.attributes.bits = kComputed;
  for (const glm::uvec3 p : {glm::uvec3(50, 50, 5), {90, 0, 0}, {0, 90, 4}, {10, 10, 1}, {20, 10, 80}})
    mesh.positions.push_back(packPosition(p));
  mesh.triangles = {{0, 1, 2}, {0, 3, 4}};
  for (const uint16_t normal : surfaceNormals(mesh))
    mesh.vertex_attributes.push_back({.normal = normal, .material = 0});
  EXPECT_EQ(normalsOf(decode(mesh, encodePayload(mesh, kUnevenStep))), normalsOf(mesh));
  EXPECT_LE(bytesOfNormals(mesh), 6);
}

class DamagedNormals : public testing::Test {
 protected:
  /// Decodes the payload with another list of normals.
  void expectRefused(std::vector<uint8_t> list, const char* why) {
    EncodedPayload damaged = payload_;
    for (const uint8_t byte : list) damaged.bytes.push_back(static_cast<std::byte>(byte));
    try {
      decode(mesh_, damaged);
      FAIL() << why;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kFormat);
    }
  }
  const Mesh mesh_ = sphereWithItsNormals();
  const EncodedPayload payload_ = encodePayload(mesh_, kUnevenStep);
};

TEST_F(DamagedNormals, areRefused) {
  expectRefused({0}, "cut off after a vertex");
  expectRefused({1, 17}, "cut off within a code");
  expectRefused({0xfe, 0xff, 0xff, 0xff, 0x0f, 0x88}, "of a vertex far beyond the last");
  expectRefused({1, 255, 3}, "off the octahedron");
  expectRefused({0x80, 0x80, 0x80, 0x80, 0x80, 0x80}, "a number without an end");
}

TEST_F(DamagedNormals, areRefusedWhereTheyFollowAMeshWithNormals) {
  Mesh mesh = mesh_;
  mesh.attributes.bits = AttributeSet::kNormal;
  EncodedPayload payload = encodePayload(mesh, kUnevenStep);
  payload.bytes.insert(payload.bytes.end(), {std::byte{0}, std::byte{0x88}});
  EXPECT_THROW(decode(mesh, payload), Error);
}

TEST_F(DamagedNormals, areRefusedIfTheModelKeepsItsFilesNormals) {
  Mesh of_file = mesh_;
  of_file.attributes.bits = AttributeSet::kNormal;
  EXPECT_THROW(decode(of_file, payload_), Error) << "a payload without normals";
}

std::vector<glm::i64vec3> sumsOf(const Mesh& mesh) {
  std::vector<glm::i64vec3> sums(mesh.positions.size(), glm::i64vec3(0));
  for (const glm::u32vec3& t : mesh.triangles)
    for (int k = 0; k < 3; ++k)
      sums[t[k]] += areaNormal(mesh.positions[t.x], mesh.positions[t.y], mesh.positions[t.z]);
  return sums;
}

TEST(CheapNormals, areWithinHalfAStepOfTheWantedNormals) {
  std::mt19937 random(7);
  std::uniform_int_distribution<int64_t> part(-1'000'000, 1'000'000);
  for (int i = 0; i < 10'000; ++i) {
    const glm::i64vec3 sum(part(random), part(random), part(random));
    const uint16_t wanted = encodeOctahedral(glm::normalize(glm::vec3(sum)) + glm::vec3(0.1f, -0.07f, 0.2f));
    const uint16_t cheap = cheapNormal(wanted, sum);
    EXPECT_LE(std::abs((cheap & 255) - (wanted & 255)), kCheapNormalSteps / 2);
    EXPECT_LE(std::abs((cheap >> 8) - (wanted >> 8)), kCheapNormalSteps / 2);
  }
}

TEST(CheapNormals, areCodesThatSurviveDecoding) {
  for (int u = 0; u < 255; ++u)
    for (int v = 0; v < 255; ++v) {
      const uint16_t wanted = encodeOctahedral(decodeOctahedral(static_cast<uint16_t>(u | v << 8)));
      const uint16_t cheap = cheapNormal(wanted, glm::i64vec3(1 + v, u - 127, 40 - v));
      EXPECT_EQ(encodeOctahedral(decodeOctahedral(cheap)), cheap);
    }
}

TEST(CheapNormals, saveAThirdOfTheBytesOfNormals) {
  Mesh mesh = test::makeSphere(60, 40, {.attributes = {AttributeSet::kNormal}, .seed = 4});
  const std::vector<glm::i64vec3> sums = sumsOf(mesh);
  std::mt19937 random(5);
  std::normal_distribution<float> off(0, 0.03f);
  for (size_t v = 0; v < sums.size(); ++v) {
    const glm::vec3 surface = glm::normalize(glm::vec3(sums[v]));
    mesh.vertex_attributes[v].normal =
        encodeOctahedral(surface + glm::vec3(off(random), off(random), off(random)));
  }
  const auto bytesOf = [](const Mesh& any) {
    return static_cast<double>(encodePayload(any, 1).bytes.size());
  };
  Mesh bare = mesh, cheap = mesh;
  bare.attributes.bits = 0;
  bare.vertex_attributes.clear();
  for (size_t v = 0; v < sums.size(); ++v)
    cheap.vertex_attributes[v].normal = cheapNormal(mesh.vertex_attributes[v].normal, sums[v]);
  EXPECT_LT(bytesOf(cheap) - bytesOf(bare), 2.0 / 3 * (bytesOf(mesh) - bytesOf(bare)));
}

}  // namespace
}  // namespace lode
