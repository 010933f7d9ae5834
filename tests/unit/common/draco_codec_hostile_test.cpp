#include <algorithm>
#include <array>
#include <random>
#include <vector>

#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <gtest/gtest.h>

#include "common/codec/draco_codec.h"
#include "common/codec/surface_normals.h"
#include "common/error.h"
#include "common/limits.h"
#include "tests/support/test_meshes.h"
#include "tests/unit/common/payload_fixture.h"
#include "tests/unit/memory_meter.h"

namespace lode {
namespace {

constexpr int64_t kMemoryLimit = 64 << 20;

struct Sample {
  Mesh mesh;
  EncodedPayload payload;
  PayloadExpectation expected;
};

/// Sets the normals to those of the surface, except for some that the payload must list.
void giveListedNormals(Mesh& mesh) {
  const std::vector<uint16_t> surface = surfaceNormals(mesh);
  for (size_t v = 0; v < surface.size(); ++v)
    mesh.vertex_attributes[v].normal = v % 10 == 3 ? static_cast<uint16_t>(surface[v] ^ 2) : surface[v];
}

Sample makeSample(uint8_t attributes, uint32_t size = 5) {
  test::MeshOptions options;
  options.attributes.bits = attributes;
  options.extent = 200;
  Sample sample;
  sample.mesh = test::makeGrid(size, size, options);
  if (options.attributes.has(AttributeSet::kComputedNormal)) giveListedNormals(sample.mesh);
  sample.payload = encodePayload(sample.mesh, kStep);
  sample.expected = {static_cast<uint32_t>(sample.mesh.triangles.size()), sample.payload.vertices,
                     sample.mesh.attributes, test::boxOf(sample.mesh)};
  return sample;
}

bool withinGuards(const Mesh& mesh, const PayloadExpectation& expected) {
  const size_t vertices = mesh.positions.size();
  if (mesh.triangles.size() != expected.triangles || vertices > expected.vertices) return false;
  if (mesh.vertex_attributes.size() != (expected.attributes.bits == 0 ? 0 : vertices)) return false;
  for (const PositionCode code : mesh.positions) {
    LatticeBox point;
    point.add(unpackPosition(code));
    if (!expected.box.contains(point)) return false;
  }
  return std::all_of(mesh.triangles.begin(), mesh.triangles.end(),
                     [&](glm::u32vec3 t) { return t.x < vertices && t.y < vertices && t.z < vertices; });
}

// Decodes untrusted bytes. @return true if the decoder refuses them.
bool decodeHostile(std::span<const std::byte> bytes, const PayloadExpectation& expected) {
  const test::MemoryMeter meter;
  bool refused = false;
  try {
    const Mesh mesh = decodePayload(bytes, kStep, expected);
    EXPECT_TRUE(withinGuards(mesh, expected));
  } catch (const Error& error) {
    refused = true;
    EXPECT_TRUE(error.code() == ErrorCode::kFormat || error.code() == ErrorCode::kLimit) << error.what();
  }
  EXPECT_LT(meter.peakBytes(), kMemoryLimit);
  return refused;
}

TEST(DracoCodecHostile, everyChangedByteIsRefusedOrDecodesWithinTheGuards) {
  for (const int attributes : {0, 1, 2, 8, 16, 31, 33}) {
    const Sample sample = makeSample(static_cast<uint8_t>(attributes));
    std::vector<std::byte> bytes = sample.payload.bytes;
    for (std::byte& byte : bytes) {
      const std::byte before = byte;
      for (unsigned value = 0; value < 256; value += attributes == 31 ? 1 : 5) {
        byte = static_cast<std::byte>(value);
        decodeHostile(bytes, sample.expected);
        ASSERT_FALSE(HasFailure()) << "attributes " << attributes << " byte " << &byte - bytes.data();
      }
      byte = before;
    }
  }
}

TEST(DracoCodecHostile, decodesAListOfNormals) {
  const size_t of_file_bytes = makeSample(AttributeSet::kNormal).payload.bytes.size();
  const size_t bare_bytes = makeSample(0).payload.bytes.size();
  const size_t listed_bytes =
      makeSample(AttributeSet::kNormal | AttributeSet::kComputedNormal).payload.bytes.size();
  EXPECT_GT(listed_bytes, bare_bytes);
  EXPECT_LT(listed_bytes, of_file_bytes);
}

TEST(DracoCodecHostile, manyChangedBytesAreRefusedOrDecodeWithinTheGuards) {
  const Sample sample = makeSample(AttributeSet::kAll, 12);
  std::mt19937 random(7);
  for (int round = 0; round < 5000; ++round) {
    std::vector<std::byte> bytes = sample.payload.bytes;
    for (auto changes = 1 + random() % 8; changes > 0; --changes)
      bytes[random() % bytes.size()] = static_cast<std::byte>(random() & 255);
    decodeHostile(bytes, sample.expected);
    ASSERT_FALSE(HasFailure()) << "round " << round;
  }
}

TEST(DracoCodecHostile, everyTruncationIsRefused) {
  for (const int attributes : {0, 31}) {
    const Sample sample = makeSample(static_cast<uint8_t>(attributes));
    const std::span<const std::byte> bytes(sample.payload.bytes);
    for (size_t length = 0; length < bytes.size(); ++length)
      EXPECT_TRUE(decodeHostile(bytes.first(length), sample.expected)) << length;
  }
}

TEST(DracoCodecHostile, bytesAfterTheEndAreRefused) {
  Sample sample = makeSample(0);
  sample.payload.bytes.push_back(std::byte{0});
  EXPECT_TRUE(decodeHostile(sample.payload.bytes, sample.expected));
}

// Returns a Draco edgebreaker header with these counts, followed by random bytes.
std::vector<std::byte> headerWith(uint64_t vertices, uint64_t faces, uint8_t seams, uint64_t symbols,
                                  uint64_t splits) {
  std::vector<uint8_t> bytes{'D', 'R', 'A', 'C', 'O', 2, 2, 1, 1, 0, 0, 0};
  const auto varint = [&](uint64_t value) {
    for (; value >= 128; value >>= 7) bytes.push_back(static_cast<uint8_t>(value | 128));
    bytes.push_back(static_cast<uint8_t>(value));
  };
  varint(vertices);
  varint(faces);
  bytes.push_back(seams);
  varint(symbols);
  varint(splits);
  bytes.resize(2700, 0x55);
  const auto view = std::as_bytes(std::span(bytes));
  return {view.begin(), view.end()};
}

void expectRefusedWithoutMemory(std::span<const std::byte> bytes, const PayloadExpectation& expected,
                                ErrorCode code) {
  const test::MemoryMeter meter;
  try {
    decodePayload(bytes, kStep, expected);
    FAIL() << "decoded";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
  }
  EXPECT_LT(meter.peakBytes(), 4096);
}

constexpr LatticeBox kEverywhere{glm::uvec3(0), glm::uvec3(kMaxLattice)};

TEST(DracoCodecHostile, threeHundredMillionFacesAreRefusedAtOnce) {
  constexpr uint32_t kMany = 300'000'000;
  const auto bytes = headerWith(kMany, kMany, 0, kMany, 0);
  expectRefusedWithoutMemory(bytes, {1000, 1000, {}, kEverywhere}, ErrorCode::kFormat);
  expectRefusedWithoutMemory(bytes, {kMany, kMany, {}, kEverywhere}, ErrorCode::kLimit);
}

TEST(DracoCodecHostile, anAnnouncementAboveTheLimitsIsRefused) {
  const Sample sample = makeSample(0);
  PayloadExpectation expected = sample.expected;
  expected.vertices = kMaxLodVertices + 1;
  expectRefusedWithoutMemory(sample.payload.bytes, expected, ErrorCode::kLimit);
}

TEST(DracoCodecHostile, moreVerticesThanAnnouncedAreRefused) {
  expectRefusedWithoutMemory(headerWith(1001, 1000, 0, 1000, 0), {1000, 1000, {}, kEverywhere},
                             ErrorCode::kFormat);
}

TEST(DracoCodecHostile, seamTablesAreRefused) {
  expectRefusedWithoutMemory(headerWith(900, 1000, 255, 1000, 0), {1000, 1000, {}, kEverywhere},
                             ErrorCode::kFormat);
}

TEST(DracoCodecHostile, moreSymbolsThanTrianglesAreRefused) {
  expectRefusedWithoutMemory(headerWith(900, 1000, 0, 1001, 0), {1000, 1000, {}, kEverywhere},
                             ErrorCode::kFormat);
  expectRefusedWithoutMemory(headerWith(900, 1000, 0, 999, 1000), {1000, 1000, {}, kEverywhere},
                             ErrorCode::kFormat);
}

TEST(DracoCodecHostile, countsOfTooManyBytesAreRefused) {
  expectRefusedWithoutMemory(headerWith(1ull << 40, 1000, 0, 0, 0), {1000, 1000, {}, kEverywhere},
                             ErrorCode::kFormat);
  expectRefusedWithoutMemory(headerWith((1ull << 32) + 5, 1000, 0, 0, 0), {1000, 1000, {}, kEverywhere},
                             ErrorCode::kFormat);
}

TEST(DracoCodecHostile, anotherNumberOfTrianglesThanAnnouncedIsRefused) {
  const Sample sample = makeSample(0);
  for (const int difference : {-1, 1}) {
    PayloadExpectation expected = sample.expected;
    expected.triangles += static_cast<uint32_t>(difference);
    EXPECT_TRUE(decodeHostile(sample.payload.bytes, expected));
  }
}

TEST(DracoCodecHostile, attributesOtherThanTheModelsAreRefused) {
  for (unsigned has = 0; has <= AttributeSet::kAll; ++has) {
    if ((has & 6) == 4) continue;  // alpha alone counts as colour
    const Sample sample = makeSample(static_cast<uint8_t>(has));
    for (unsigned wanted = 0; wanted <= AttributeSet::kAll; ++wanted) {
      // Skip colour with alpha in place of colour without alpha, which equals constant alpha.
      if (has == wanted || (wanted & 6) == 4 || (wanted == (has | 4) && (has & 2))) continue;
      PayloadExpectation expected = sample.expected;
      expected.attributes.bits = static_cast<uint8_t>(wanted);
      EXPECT_TRUE(decodeHostile(sample.payload.bytes, expected)) << has << " for " << wanted;
    }
  }
}

TEST(DracoCodecHostile, positionsOutsideTheNodesBoxAreRefused) {
  const Sample sample = makeSample(0);
  for (int axis = 0; axis < 3; ++axis) {
    PayloadExpectation low = sample.expected, high = sample.expected;
    ++low.box.min[axis];
    --high.box.max[axis];
    EXPECT_TRUE(decodeHostile(sample.payload.bytes, low));
    EXPECT_TRUE(decodeHostile(sample.payload.bytes, high));
  }
}

TEST(DracoCodecHostile, anotherStepIsRefused) {
  const Sample sample = makeSample(0);
  EXPECT_THROW(decodePayload(sample.payload.bytes, kStep * 2, sample.expected), Error);
  EXPECT_THROW(decodePayload(sample.payload.bytes, kStep / 2, sample.expected), Error);
}

// Encodes a single triangle with Draco directly, with other settings than encodePayload().
std::vector<std::byte> encodeByDraco(int method, int position_bits, int extra_components) {
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(1);
  const int position = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  const std::array<float, 3> a{0, 0, 0}, b{1, 0, 0}, c{0, 1, 0};
  builder.SetAttributeValuesForFace(position, draco::FaceIndex(0), a.data(), b.data(), c.data());
  if (extra_components > 0) {
    const int extra = builder.AddAttribute(draco::GeometryAttribute::GENERIC,
                                           static_cast<int8_t>(extra_components), draco::DT_UINT16);
    const std::vector<uint16_t> zero(static_cast<size_t>(extra_components));
    builder.SetAttributeValuesForFace(extra, draco::FaceIndex(0), zero.data(), zero.data(), zero.data());
  }
  draco::Encoder encoder;
  encoder.SetEncodingMethod(method);
  if (position_bits > 0) encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, position_bits);
  draco::EncoderBuffer buffer;
  const auto mesh = builder.Finalize();
  EXPECT_TRUE(encoder.EncodeMeshToBuffer(*mesh, &buffer).ok());
  const auto bytes = std::as_bytes(std::span(buffer.data(), buffer.size()));
  return {bytes.begin(), bytes.end()};
}

PayloadExpectation expectedTriangle(uint8_t attributes) { return {1, 3, {attributes}, kEverywhere}; }

TEST(DracoCodecHostile, aStepThatNoStoreHasIsRefused) {
  const Sample sample = makeSample(0);
  for (const double step : {0.0, 0.3, -1.0, 0x1p-200}) {
    try {
      decodePayload(sample.payload.bytes, step, sample.expected);
      FAIL() << "decoded";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kFormat);
    }
  }
}

TEST(DracoCodecHostile, sequentialMeshesAreRefused) {
  EXPECT_TRUE(decodeHostile(encodeByDraco(draco::MESH_SEQUENTIAL_ENCODING, 8, 0), expectedTriangle(0)));
}

TEST(DracoCodecHostile, positionsThatAreNotQuantizedAreRefused) {
  EXPECT_TRUE(decodeHostile(encodeByDraco(draco::MESH_EDGEBREAKER_ENCODING, 0, 0), expectedTriangle(0)));
}

TEST(DracoCodecHostile, positionsOffTheLatticeAreRefused) {
  EXPECT_TRUE(decodeHostile(encodeByDraco(draco::MESH_EDGEBREAKER_ENCODING, 8, 0), expectedTriangle(0)));
}

TEST(DracoCodecHostile, wideAttributesAreRefused) {
  EXPECT_TRUE(decodeHostile(encodeByDraco(draco::MESH_EDGEBREAKER_ENCODING, 8, 100), expectedTriangle(0)));
  EXPECT_TRUE(decodeHostile(encodeByDraco(draco::MESH_EDGEBREAKER_ENCODING, 8, 2),
                            expectedTriangle(AttributeSet::kMaterial)));
}

}  // namespace
}  // namespace lode
