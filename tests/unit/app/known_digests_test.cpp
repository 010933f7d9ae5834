#include <vector>

#include <gtest/gtest.h>

#include "client/loadtest/load_client.h"

namespace lode::app {
namespace {

BlobRef refTo(std::span<const std::byte> bytes) {
  return {1, static_cast<uint32_t>(bytes.size()), digestOf(bytes)};
}

TEST(KnownDigests, areThoseOfTheirBytesHoweverOftenTheyCome) {
  KnownDigests names;
  const std::vector<std::byte> bytes(1000, std::byte{1}), others(1000, std::byte{2});
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(names.matchesDigest(refTo(bytes), bytes));
    EXPECT_TRUE(names.matchesDigest(refTo(others), others));
  }
}

TEST(KnownDigests, areNotThoseOfOtherBytesWhetherTheFirstOrNot) {
  KnownDigests names;
  const std::vector<std::byte> bytes(1000, std::byte{1});
  std::vector<std::byte> changed = bytes;
  changed[500] ^= std::byte{1};
  EXPECT_FALSE(names.matchesDigest(refTo(bytes), changed));
  EXPECT_TRUE(names.matchesDigest(refTo(bytes), bytes));
  EXPECT_FALSE(names.matchesDigest(refTo(bytes), changed));
}

}  // namespace
}  // namespace lode::app
