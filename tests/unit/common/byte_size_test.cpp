#include "common/byte_size.h"

#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "common/error.h"

namespace lode {
namespace {

TEST(ByteSize, isANumberOfBytesWithoutAUnit) {
  EXPECT_EQ(parseByteSize("0"), 0u);
  EXPECT_EQ(parseByteSize("500000000"), 500'000'000u);
  EXPECT_EQ(parseByteSize("12B"), 12u);
  EXPECT_EQ(parseByteSize("18446744073709551615"), std::numeric_limits<uint64_t>::max());
}

TEST(ByteSize, countsInPowersOf1000WithAB) {
  EXPECT_EQ(parseByteSize("4KB"), 4000u);
  EXPECT_EQ(parseByteSize("512MB"), 512'000'000u);
  EXPECT_EQ(parseByteSize("2gb"), 2'000'000'000u);
  EXPECT_EQ(parseByteSize("1 TB"), 1'000'000'000'000u);
}

TEST(ByteSize, countsInPowersOf1024WithAnIOrAsASingleLetter) {
  EXPECT_EQ(parseByteSize("3KiB"), 3u << 10);
  EXPECT_EQ(parseByteSize("3k"), 3u << 10);
  EXPECT_EQ(parseByteSize("512MiB"), 512u << 20);
  EXPECT_EQ(parseByteSize("512M"), 512u << 20);
  EXPECT_EQ(parseByteSize("2G"), 2ull << 30);
  EXPECT_EQ(parseByteSize("16777215T"), 16777215ull << 40);
}

TEST(ByteSize, takesFractionsOfAUnit) {
  EXPECT_EQ(parseByteSize("0.5GB"), 500'000'000u);
  EXPECT_EQ(parseByteSize("1.5G"), 3ull << 29);
  EXPECT_EQ(parseByteSize(".25KiB"), 256u);
}

TEST(ByteSize, isPrintedInThreeDigitsRoundedUp) {
  EXPECT_EQ(byteSizeAtLeast(999), "999");
  EXPECT_EQ(byteSizeAtLeast(180355072), "181MB");
  EXPECT_EQ(byteSizeAtLeast(68719476736), "68.8GB");
  EXPECT_EQ(byteSizeAtLeast(4000), "4.00KB");
  EXPECT_EQ(byteSizeAtLeast(99'999'999), "100MB");
  EXPECT_EQ(byteSizeAtLeast(999'600'000), "1.00GB");
  for (const uint64_t bytes : {uint64_t{1}, uint64_t{9991}, uint64_t{99'999'999}, uint64_t{999'999'999'999}})
    EXPECT_GE(parseByteSize(byteSizeAtLeast(bytes)), bytes);
}

TEST(ByteSize, refusesOtherTextsWithExamples) {
  for (const char* text :
       {"", "M", "MB", "-1", "+1", "1XB", "1MBs", "0.5", "1.2.3GB", ".GB", "1e9", "0x10", "1,5GB", "512MB ",
        " 512MB", "18446744073709551616", "16777216T", "99999999.5TB"}) {
    try {
      parseByteSize(text);
      ADD_FAILURE() << text;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kUsage);
      EXPECT_NE(std::string(error.what()).find("512MB, 1.5GB or 512MiB"), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace lode
