#include <vector>

#include <gtest/gtest.h>

#include "client/loadtest/load_client.h"

namespace lode::app {
namespace {

BlobRef refTo(std::span<const std::byte> bytes) {
  return {1, static_cast<uint32_t>(bytes.size()), digestOf(bytes)};
}

TEST(KnownDigests, matchTheirBytesOnEveryCheck) {
  KnownDigests names;
  const std::vector<std::byte> bytes(1000, std::byte{1}), others(1000, std::byte{2});
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(names.matchesDigest(refTo(bytes), bytes));
    EXPECT_TRUE(names.matchesDigest(refTo(others), others));
  }
}

TEST(KnownDigests, neverMatchOtherBytes) {
  KnownDigests names;
  const std::vector<std::byte> bytes(1000, std::byte{1});
  std::vector<std::byte> changed = bytes;
  changed[500] ^= std::byte{1};
  EXPECT_FALSE(names.matchesDigest(refTo(bytes), changed));
  EXPECT_TRUE(names.matchesDigest(refTo(bytes), bytes));
  EXPECT_FALSE(names.matchesDigest(refTo(bytes), changed));
}

TEST(KnownDigests, areForgottenAboveTheLimit) {
  KnownDigests names;
  for (uint32_t number = 0; number <= kMaxKnownDigests; ++number) {
    const auto bytes = std::as_bytes(std::span(&number, 1));
    ASSERT_TRUE(names.matchesDigest(refTo(bytes), bytes));
    ASSERT_LE(names.size(), kMaxKnownDigests);
  }
}

}  // namespace
}  // namespace lode::app
