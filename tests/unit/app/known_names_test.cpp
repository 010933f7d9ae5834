#include "client/app/cli/known_names.h"

#include <vector>

#include <gtest/gtest.h>

namespace lode::app {
namespace {

BlobRef refTo(std::span<const std::byte> bytes) {
  return {1, static_cast<uint32_t>(bytes.size()), nameBlob(bytes)};
}

TEST(KnownNames, areThoseOfTheirBytesHoweverOftenTheyCome) {
  KnownNames names;
  const std::vector<std::byte> bytes(1000, std::byte{1}), others(1000, std::byte{2});
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(names.isNamed(refTo(bytes), bytes));
    EXPECT_TRUE(names.isNamed(refTo(others), others));
  }
}

TEST(KnownNames, areNotThoseOfOtherBytesWhetherTheFirstOrNot) {
  KnownNames names;
  const std::vector<std::byte> bytes(1000, std::byte{1});
  std::vector<std::byte> changed = bytes;
  changed[500] ^= std::byte{1};
  EXPECT_FALSE(names.isNamed(refTo(bytes), changed));
  EXPECT_TRUE(names.isNamed(refTo(bytes), bytes));
  EXPECT_FALSE(names.isNamed(refTo(bytes), changed));
}

}  // namespace
}  // namespace lode::app
