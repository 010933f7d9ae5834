#include "common/codec/octahedral.h"

#include <cmath>
#include <limits>
#include <random>

#include <draco/compression/attributes/normal_compression_utils.h>
#include <gtest/gtest.h>

namespace lode {
namespace {

uint16_t dracoCode(glm::vec3 normal) {
  draco::OctahedronToolBox box;
  box.SetQuantizationBits(8);
  int32_t s, t;
  box.FloatVectorToQuantizedOctahedralCoords(&normal.x, &s, &t);
  return static_cast<uint16_t>(s | t << 8);
}

uint16_t dracoCanonical(int s, int t) {
  draco::OctahedronToolBox box;
  box.SetQuantizationBits(8);
  box.CanonicalizeOctahedralCoords(s, t, &s, &t);
  return static_cast<uint16_t>(s | t << 8);
}

TEST(Octahedral, agreesWithDracoOnRandomDirections) {
  std::mt19937 random(1);
  std::normal_distribution<float> normal;
  for (int i = 0; i < 200000; ++i) {
    const glm::vec3 n(normal(random), normal(random), normal(random));
    ASSERT_EQ(encodeOctahedral(n), dracoCode(n)) << n.x << ' ' << n.y << ' ' << n.z;
  }
}

TEST(Octahedral, agreesWithDracoWhereComponentsVanish) {
  for (int x = -2; x <= 2; ++x)
    for (int y = -2; y <= 2; ++y)
      for (int z = -2; z <= 2; ++z) {
        if (x == 0 && y == 0 && z == 0) continue;
        const glm::vec3 n(x, y, z);
        ASSERT_EQ(encodeOctahedral(n), dracoCode(n)) << x << ' ' << y << ' ' << z;
      }
}

TEST(Octahedral, reencodesEveryCodeInItsCanonicalForm) {
  for (int s = 0; s < 255; ++s)
    for (int t = 0; t < 255; ++t) {
      const uint16_t code = static_cast<uint16_t>(s | t << 8);
      ASSERT_EQ(encodeOctahedral(decodeOctahedral(code)), dracoCanonical(s, t)) << s << ' ' << t;
    }
}

TEST(Octahedral, decodesWithinHalfAStepOfTheDirection) {
  std::mt19937 random(2);
  std::normal_distribution<float> normal;
  for (int i = 0; i < 20000; ++i) {
    const glm::vec3 n = glm::normalize(glm::vec3(normal(random), normal(random), normal(random)));
    ASSERT_GT(glm::dot(n, decodeOctahedral(encodeOctahedral(n))), std::cos(glm::radians(1.2f)));
  }
}

TEST(Octahedral, decodesToUnitVectors) {
  for (int code = 0; code < 65536; ++code)
    ASSERT_NEAR(glm::length(decodeOctahedral(static_cast<uint16_t>(code))), 1, 1e-6) << code;
}

TEST(Octahedral, lengthDoesNotMatter) {
  const glm::vec3 n(0.3f, -0.7f, 0.2f);
  for (const float scale : {1e-30f, 1e-7f, 1e7f, 1e30f})
    EXPECT_EQ(encodeOctahedral(scale * n), encodeOctahedral(n)) << scale;
}

TEST(Octahedral, aVectorWithoutDirectionCountsAsUp) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  const uint16_t up = encodeOctahedral({0, 0, 1});
  EXPECT_EQ(encodeOctahedral({0, 0, 0}), up);
  EXPECT_EQ(encodeOctahedral({nan, 0, 0}), up);
  EXPECT_EQ(encodeOctahedral({0, -inf, 0}), up);
}

}  // namespace
}  // namespace lode
