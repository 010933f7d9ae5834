#include "client/web/core/sha256.h"

#include <algorithm>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "common/codec/blob.h"

namespace lode::web {
namespace {

TEST(Sha256, equalsOpenSslForEveryLengthAroundABlock) {
  std::mt19937 random(7);
  for (size_t length = 0; length < 200; ++length) {
    std::vector<std::byte> bytes(length);
    std::ranges::generate(bytes, [&] { return static_cast<std::byte>(random()); });
    const Digest expected = digestOf(bytes);
    const std::array<std::byte, 32> digest = sha256(bytes);
    EXPECT_TRUE(std::ranges::equal(expected.bytes, std::span(digest).first<16>())) << length;
  }
}

TEST(Sha256, hasTheLastBytesOfTheStandardsExample) {
  const char text[] = {'a', 'b', 'c'};
  const std::array<std::byte, 32> digest = sha256(std::as_bytes(std::span(text)));
  EXPECT_EQ(digest[30], std::byte{0x15});
  EXPECT_EQ(digest[31], std::byte{0xad});
}

}  // namespace
}  // namespace lode::web
