#include "common/codec/draco_codec.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <ctime>
#include <map>
#include <random>
#include <tuple>

#include <draco/compression/decode.h>
#include <draco/mesh/mesh.h>
#include <gtest/gtest.h>

#include "common/codec/octahedral.h"
#include "common/error.h"
#include "common/limits.h"
#include "tests/support/test_meshes.h"
#include "tests/unit/common/payload_fixture.h"

namespace lode {
namespace {

using Corner = std::array<uint64_t, 3>;  // position and attributes
using Corners = std::array<Corner, 3>;

Corner cornerOf(const Mesh& mesh, uint32_t vertex) {
  VertexAttributes attributes;
  if (!mesh.vertex_attributes.empty()) attributes = mesh.vertex_attributes[vertex];
  std::array<uint64_t, 2> packed{};
  std::memcpy(packed.data(), &attributes, sizeof attributes);
  return {mesh.positions[vertex].value, packed[0], packed[1]};
}

// Returns the sorted triangles, each rotated so that its smallest corner comes first.
std::vector<Corners> trianglesOf(const Mesh& mesh) {
  std::vector<Corners> result;
  for (const glm::u32vec3 t : mesh.triangles) {
    Corners corners{cornerOf(mesh, t.x), cornerOf(mesh, t.y), cornerOf(mesh, t.z)};
    const Corners next{corners[1], corners[2], corners[0]}, last{corners[2], corners[0], corners[1]};
    result.push_back(std::min({corners, next, last}));
  }
  std::sort(result.begin(), result.end());
  return result;
}

void expectRoundTrip(const Mesh& mesh, double step = kStep) {
  const EncodedPayload payload = encodePayload(mesh, step);
  const Mesh decoded = decodePayload(payload.bytes, step, expectationOf(mesh, payload));
  EXPECT_EQ(decoded.positions.size(), payload.vertices);
  EXPECT_EQ(decoded.attributes, mesh.attributes);
  EXPECT_TRUE(trianglesOf(decoded) == trianglesOf(mesh));
}

Mesh makeMesh(std::vector<glm::uvec3> positions, std::vector<glm::u32vec3> triangles) {
  Mesh mesh;
  for (const glm::uvec3 p : positions) mesh.positions.push_back(packPosition(p));
  mesh.triangles = std::move(triangles);
  return mesh;
}

TEST(DracoCodec, everySetOfAttributesComesBackExactly) {
  for (unsigned bits = 0; bits <= AttributeSet::kAll; ++bits) {
    test::MeshOptions options;
    options.attributes.bits = static_cast<uint8_t>(bits);
    options.seed = bits + 1;
    SCOPED_TRACE(bits);
    expectRoundTrip(test::makeGrid(13, 9, options));
    expectRoundTrip(test::makeSphere(16, 10, options));
  }
}

TEST(DracoCodec, computedNormalsAreCodedAsNormals) {
  test::MeshOptions options;
  options.attributes.bits = AttributeSet::kNormal | AttributeSet::kComputedNormal;
  expectRoundTrip(test::makeGrid(5, 5, options));
}

TEST(DracoCodec, everyExtentOfTheLatticeComesBackExactly) {
  for (int bits = 1; bits <= kLatticeBits; ++bits) {
    test::MeshOptions options;
    options.extent = (1u << bits) - 1;
    options.seed = static_cast<uint32_t>(bits);
    options.attributes.bits = AttributeSet::kNormal;
    SCOPED_TRACE(bits);
    expectRoundTrip(test::makeGrid(12, 12, options));
    if (bits >= 8) expectRoundTrip(test::makeSphere(24, 20, options));
  }
}

TEST(DracoCodec, everyStepComesBackExactly) {
  test::MeshOptions options;
  options.extent = kMaxLattice;
  const Mesh mesh = test::makeGrid(6, 6, options);
  for (const double step : {0x1p-60, 5 * 0x1p-30, 6 * 0x1p-13, 7 * 0x1p-7, 1.0, 0x1p9, 7 * 0x1p40}) {
    SCOPED_TRACE(step);
    expectRoundTrip(mesh, step);
  }
}

TEST(DracoCodec, aCornerOfTheLatticeComesBackExactly) {
  const uint32_t m = kMaxLattice;
  expectRoundTrip(makeMesh({{m, m, m}, {m - 1, m, m}, {m, m - 1, m}}, {{0, 1, 2}}));
}

// Returns the positions that glTF readers get: decoded by Draco itself, as floats.
std::map<std::tuple<float, float, float>, int> plainPositions(const EncodedPayload& payload) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(payload.bytes.data()), payload.bytes.size());
  draco::Decoder decoder;
  const auto mesh = std::move(decoder.DecodeMeshFromBuffer(&buffer)).value();
  const draco::PointAttribute* attribute = mesh->GetNamedAttribute(draco::GeometryAttribute::POSITION);
  std::map<std::tuple<float, float, float>, int> result;
  for (uint32_t i = 0; i < mesh->num_points(); ++i) {
    std::array<float, 3> p;
    attribute->GetMappedValue(draco::PointIndex(i), p.data());
    ++result[{p[0], p[1], p[2]}];
  }
  return result;
}

TEST(DracoCodec, plainDracoDecodesExactFloatsOfTheModelFrame) {
  for (int bits = 8; bits <= kLatticeBits; ++bits)
    for (const double step : {0x1p-20, 5 * 0x1p-7, 6 * 0x1p-9, 7 * 0x1p3}) {
      test::MeshOptions options;
      options.extent = (1u << bits) - 1;
      options.origin = glm::uvec3((kMaxLattice - options.extent) / 3 * 2);
      options.bump = 0.2;
      const Mesh mesh = test::makeGrid(9, 9, options);
      std::map<std::tuple<float, float, float>, int> expected;
      for (const PositionCode code : mesh.positions) {
        const glm::vec3 p = Lattice{{}, step}.toModel(unpackPosition(code));
        ++expected[{p.x, p.y, p.z}];
      }
      ASSERT_TRUE(plainPositions(encodePayload(mesh, step)) == expected) << bits << ' ' << step;
    }
}

TEST(DracoCodec, neighboursDecodeTheirSharedVerticesToTheSameBits) {
  for (int bits = 8; bits < kLatticeBits; ++bits) {
    test::MeshOptions left, right;
    left.extent = right.extent = 1u << bits;
    left.bump = right.bump = 0.3;
    left.seed = right.seed = static_cast<uint32_t>(bits);
    left.origin = {0, 0, 7};
    right.origin = {left.extent, 0, 7};
    if (right.origin.x + right.extent > kMaxLattice) break;
    const auto a = plainPositions(encodePayload(test::makeGrid(16, 16, left), kStep));
    const auto b = plainPositions(encodePayload(test::makeGrid(16, 16, right), kStep));
    const auto shared = std::count_if(a.begin(), a.end(), [&](const auto& p) { return b.contains(p.first); });
    EXPECT_EQ(shared, 17) << bits;
  }
}

TEST(DracoCodec, everyOctahedralCodeComesBack) {
  test::MeshOptions options;
  options.attributes.bits = AttributeSet::kNormal;
  Mesh mesh = test::makeGrid(254, 254, options);
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    const auto code = static_cast<uint16_t>(i % 255 | i / 255 << 8);
    mesh.vertex_attributes[i].normal = encodeOctahedral(decodeOctahedral(code));
  }
  expectRoundTrip(mesh);
}

TEST(DracoCodec, everyTextureStepComesBack) {
  test::MeshOptions options;
  options.attributes.bits = AttributeSet::kTexture;
  Mesh mesh = test::makeGrid(255, 255, options);
  for (size_t i = 0; i < mesh.positions.size(); ++i)
    mesh.vertex_attributes[i].texture = glm::u16vec2(i, 65535 - i);
  expectRoundTrip(mesh);
}

TEST(DracoCodec, everyMaterialComesBack) {
  test::MeshOptions options;
  options.attributes.bits = AttributeSet::kMaterial;
  Mesh mesh = test::makeGrid(255, 255, options);
  for (size_t i = 0; i < mesh.positions.size(); ++i)
    mesh.vertex_attributes[i].material = static_cast<uint16_t>(i);
  expectRoundTrip(mesh);
}

TEST(DracoCodec, opaqueAlphaCostsNothing) {
  test::MeshOptions options;
  options.attributes.bits = AttributeSet::kColour;
  Mesh mesh = test::makeGrid(30, 30, options);
  const size_t without = encodePayload(mesh, kStep).bytes.size();
  mesh.attributes.bits |= AttributeSet::kAlpha;
  EXPECT_EQ(encodePayload(mesh, kStep).bytes.size(), without);
  expectRoundTrip(mesh);
}

TEST(DracoCodec, compressesOriginalsAndFarLodsMoreThanOtherLods) {
  const Mesh mesh = test::makeGrid(60, 60, {.attributes = {}, .seed = 2, .bump = 0.2});
  const size_t simplified = encodePayload(mesh, kStep, MeshSource::kSimplified).bytes.size();
  for (const MeshSource source : {MeshSource::kFile, MeshSource::kFarLod}) {
    const EncodedPayload closer = encodePayload(mesh, kStep, source);
    EXPECT_LT(closer.bytes.size(), simplified);
    const Mesh decoded = decodePayload(closer.bytes, kStep, expectationOf(mesh, closer));
    EXPECT_TRUE(trianglesOf(decoded) == trianglesOf(mesh));
  }
}

TEST(DracoCodec, traversesOriginalsInTheBestPredictedOrder) {
  Mesh mesh = test::makeGrid(60, 60, {.attributes = {}, .seed = 2, .bump = 0.2});
  const size_t alone = encodePayload(mesh, kStep, MeshSource::kFile).bytes.size();
  mesh.attributes.bits = AttributeSet::kMaterial;
  mesh.vertex_attributes.assign(mesh.positions.size(), {});
  EXPECT_LT(alone, encodePayload(mesh, kStep, MeshSource::kFile).bytes.size() * 98 / 100);
}

TEST(DracoCodec, isDeterministic) {
  test::MeshOptions options;
  options.attributes.bits = AttributeSet::kAll;
  const Mesh mesh = test::makeSphere(20, 20, options);
  EXPECT_EQ(encodePayload(mesh, kStep).bytes, encodePayload(mesh, kStep).bytes);
}

TEST(DracoCodec, noTrianglesAreNoBytes) {
  const EncodedPayload payload = encodePayload(makeMesh({{1, 2, 3}}, {}), kStep);
  EXPECT_TRUE(payload.bytes.empty());
  EXPECT_EQ(payload.vertices, 0u);
  EXPECT_TRUE(decodePayload({}, kStep, {}).triangles.empty());
}

TEST(DracoCodec, oneTriangleComesBack) {
  expectRoundTrip(makeMesh({{0, 0, 0}, {9, 0, 0}, {0, 9, 4}}, {{0, 1, 2}}));
}

TEST(DracoCodec, duplicateTrianglesComeBackTwice) {
  expectRoundTrip(makeMesh({{0, 0, 0}, {9, 0, 0}, {0, 9, 4}}, {{0, 1, 2}, {0, 1, 2}, {1, 2, 0}}));
}

TEST(DracoCodec, mirroredTrianglesKeepTheirOrientation) {
  expectRoundTrip(makeMesh({{0, 0, 0}, {9, 0, 0}, {0, 9, 4}, {5, 5, 5}}, {{0, 1, 2}, {0, 2, 1}, {0, 1, 3}}));
}

TEST(DracoCodec, edgesOfManyTrianglesComeBack) {
  expectRoundTrip(makeMesh({{0, 0, 0}, {9, 0, 0}, {0, 9, 4}, {5, 5, 5}, {1, 2, 8}},
                           {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}, {1, 0, 2}}));
}

TEST(DracoCodec, fansThatTouchInOneVertexComeBack) {
  const Mesh mesh = makeMesh({{5, 5, 5}, {9, 0, 0}, {0, 9, 4}, {1, 1, 1}, {2, 1, 8}}, {{0, 1, 2}, {0, 3, 4}});
  expectRoundTrip(mesh);
  EXPECT_EQ(encodePayload(mesh, kStep).vertices, 6u);
}

TEST(DracoCodec, flatTrianglesComeBack) {
  expectRoundTrip(makeMesh({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 0, 0}}, {{0, 1, 2}, {0, 2, 3}}));
  expectRoundTrip(makeMesh({{4, 4, 4}, {4, 4, 4}, {4, 4, 4}}, {{0, 1, 2}}));
}

TEST(DracoCodec, randomSoupComesBack) {
  std::mt19937 random(5);
  for (int round = 0; round < 50; ++round) {
    Mesh mesh;
    mesh.attributes.bits = AttributeSet::kNormal | AttributeSet::kColour;
    const uint32_t vertices = 3 + static_cast<uint32_t>(random() % 40);
    for (uint32_t i = 0; i < vertices; ++i) {
      const glm::uvec3 p(random() & 63, random() & 63, random() & 63);
      mesh.positions.push_back(packPosition(p));
      mesh.vertex_attributes.push_back(test::attributesAt(p, glm::vec3(1, 2, 3), {mesh.attributes}));
    }
    for (int i = 0; i < 60; ++i) {
      const glm::u32vec3 t(random() % vertices, random() % vertices, random() % vertices);
      if (t.x != t.y && t.y != t.z && t.z != t.x) mesh.triangles.push_back(t);
    }
    if (!mesh.triangles.empty()) expectRoundTrip(mesh);
  }
}

TEST(DracoCodec, verticesWithoutTriangleAreDropped) {
  const Mesh mesh = makeMesh({{7, 7, 7}, {0, 0, 0}, {9, 0, 0}, {0, 9, 4}, {8, 8, 8}}, {{1, 2, 3}});
  expectRoundTrip(mesh);
  EXPECT_EQ(encodePayload(mesh, kStep).vertices, 3u);
}

void expectRefusedToEncode(const Mesh& mesh, double step) {
  try {
    encodePayload(mesh, step);
    FAIL() << "encoded";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInternal);
  }
}

TEST(DracoCodec, refusesAMeshThatIsOurOwnMistake) {
  const Mesh good = makeMesh({{0, 0, 0}, {9, 0, 0}, {0, 9, 4}}, {{0, 1, 2}});
  Mesh beyond = good, twice = good, bare = good;
  beyond.triangles[0].z = 3;
  twice.triangles[0].z = 1;
  bare.attributes.bits = AttributeSet::kNormal;
  expectRefusedToEncode(beyond, kStep);
  expectRefusedToEncode(twice, kStep);
  expectRefusedToEncode(bare, kStep);
}

TEST(DracoCodec, refusesAStepThatNoStoreHas) {
  const Mesh mesh = makeMesh({{0, 0, 0}, {9, 0, 0}, {0, 9, 4}}, {{0, 1, 2}});
  for (const double step : {0.0, -1.0, 0.3, 1e30, std::nan(""), double(INFINITY), 0x1p-200})
    expectRefusedToEncode(mesh, step);
}

TEST(DracoCodec, refusesMoreTrianglesThanALodMayHave) {
  Mesh mesh = makeMesh({{0, 0, 0}, {9, 0, 0}, {0, 9, 4}}, {});
  mesh.triangles.assign(kMaxLodTriangles + 1, {0, 1, 2});
  EXPECT_THROW(encodePayload(mesh, kStep), Error);
}

double cpuSecondsOfCoincident(uint32_t triangles) {
  Mesh mesh;
  mesh.positions = {packPosition({0, 0, 0}), packPosition({5, 0, 0}), packPosition({0, 7, 0})};
  mesh.triangles.assign(triangles, {0, 1, 2});
  const clock_t before = std::clock();
  const EncodedPayload payload = encodePayload(mesh, kStep);
  const Mesh decoded = decodePayload(payload.bytes, kStep, expectationOf(mesh, payload));
  const double seconds = static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC;
  EXPECT_EQ(decoded.triangles.size(), triangles);
  for (const glm::u32vec3& t : decoded.triangles)
    EXPECT_EQ(cornerOf(decoded, t.x)[0] + cornerOf(decoded, t.y)[0] + cornerOf(decoded, t.z)[0],
              mesh.positions[0].value + mesh.positions[1].value + mesh.positions[2].value);
  return seconds;
}

TEST(DracoCodec, takesTimeInProportionToCoincidentTriangles) {
  const double few = cpuSecondsOfCoincident(25000);
  EXPECT_LT(cpuSecondsOfCoincident(200000), 20 * few + 0.1);
}

}  // namespace
}  // namespace lode
