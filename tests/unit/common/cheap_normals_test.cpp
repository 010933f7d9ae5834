#include "common/codec/cheap_normals.h"

#include <random>

#include <gtest/gtest.h>

#include "common/codec/draco_codec.h"
#include "common/codec/octahedral.h"
#include "common/codec/surface_normals.h"
#include "tests/support/test_meshes.h"

namespace lode {
namespace {

std::vector<glm::i64vec3> sumsOf(const Mesh& mesh) {
  std::vector<glm::i64vec3> sums(mesh.positions.size(), glm::i64vec3(0));
  for (const glm::u32vec3& t : mesh.triangles)
    for (int k = 0; k < 3; ++k)
      sums[t[k]] += areaNormal(mesh.positions[t.x], mesh.positions[t.y], mesh.positions[t.z]);
  return sums;
}

TEST(CheapNormals, areWithinHalfAStepOfThoseThatAreWanted) {
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

TEST(CheapNormals, areCodesThatAPayloadGivesBack) {
  for (int u = 0; u < 255; ++u)
    for (int v = 0; v < 255; ++v) {
      const uint16_t wanted = encodeOctahedral(decodeOctahedral(static_cast<uint16_t>(u | v << 8)));
      const uint16_t cheap = cheapNormal(wanted, glm::i64vec3(1 + v, u - 127, 40 - v));
      EXPECT_EQ(encodeOctahedral(decodeOctahedral(cheap)), cheap);
    }
}

TEST(CheapNormals, saveAThirdOfWhatNormalsTake) {
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
