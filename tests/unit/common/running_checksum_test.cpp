#include "common/codec/running_checksum.h"

#include <string>

#include <gtest/gtest.h>

#include "common/codec/blob.h"
#include "tests/support/bytes.h"

namespace lode {
namespace {

TEST(RunningChecksum, isTheChecksumOfAllPiecesTogether) {
  std::string all;
  RunningChecksum running;
  EXPECT_EQ(running.value(), checksum({}));
  for (const size_t bytes : {1u, 0u, 239u, 1u, 1000u, 70000u}) {
    const std::string piece(bytes, static_cast<char>('a' + bytes % 7));
    running.add(test::bytesOf(piece));
    all += piece;
    EXPECT_EQ(running.value(), checksum(test::bytesOf(all))) << all.size();
  }
}

TEST(RunningChecksum, keepsItsStateWhenMoved) {
  RunningChecksum first;
  first.add(test::bytesOf("abc"));
  RunningChecksum second = std::move(first);
  second.add(test::bytesOf("def"));
  EXPECT_EQ(second.value(), checksum(test::bytesOf("abcdef")));
}

}  // namespace
}  // namespace lode
