#include "common/image/srgb.h"

#include <gtest/gtest.h>

namespace lode {
namespace {

TEST(Srgb, comesBackFromLinearLightAsItWas) {
  for (int byte = 0; byte < 256; ++byte) {
    const auto srgb = static_cast<uint8_t>(byte);
    EXPECT_EQ(srgbOf(linearOf(srgb)), srgb);
  }
}

TEST(Srgb, hasHalfOfTheLightWellAboveTheMiddleOfItsBytes) {
  EXPECT_EQ(srgbOf(0.5), 188);
  EXPECT_EQ(srgbOf(2), 255);
  EXPECT_EQ(srgbOf(-1), 0);
}

}  // namespace
}  // namespace lode
