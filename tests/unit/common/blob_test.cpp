#include "common/codec/blob.h"

#include <gtest/gtest.h>

#include "tests/support/bytes.h"

namespace lode {
namespace {

using test::bytesOf;

TEST(Blob, isNamedByTheFirstHalfOfItsSha256) {
  // Start of the SHA-256 of "abc": FIPS 180-2, appendix B.1.
  EXPECT_EQ(toHex(digestOf(bytesOf("abc"))), "ba7816bf8f01cfea414140de5dae2223");
  EXPECT_EQ(toHex(digestOf({})), "e3b0c44298fc1c149afbf4c8996fb924");
}

TEST(Blob, namesCompareByTheirBytes) {
  EXPECT_EQ(digestOf(bytesOf("a")), digestOf(bytesOf("a")));
  EXPECT_NE(digestOf(bytesOf("a")), digestOf(bytesOf("b")));
}

TEST(Blob, checksumIsXxh3) {
  EXPECT_EQ(checksum({}), 0x2D06800538D394C2u);  // XXH3_64bits of no bytes, seed 0 (xxHash's specification)
}

TEST(Blob, checksumSeesEveryBit) {
  std::string text(300, 'x');
  const uint64_t before = checksum(bytesOf(text));
  for (char& letter : text)
    for (int bit = 0; bit < 8; ++bit) {
      letter = static_cast<char>(letter ^ 1 << bit);
      ASSERT_NE(checksum(bytesOf(text)), before);
      letter = static_cast<char>(letter ^ 1 << bit);
    }
}

TEST(Blob, isAbsentIfItsNumberIsZero) {
  EXPECT_FALSE(BlobRef());
  EXPECT_TRUE((BlobRef{1, 10, {}}));
}

}  // namespace
}  // namespace lode
