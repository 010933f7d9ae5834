#include "proto/frame.h"

#include <vector>

#include <gtest/gtest.h>

#include "common/error.h"
#include "common/limits.h"
#include "proto/limits.h"

namespace lode::proto {
namespace {

ErrorCode errorOf(const auto& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.code();
  }
  ADD_FAILURE() << "nothing was thrown";
  return ErrorCode::kInternal;
}

std::vector<std::byte> blobBody(const BlobChunkHeader& header, size_t bytes) {
  const auto head = encodeBlobChunkHeader(header);
  std::vector<std::byte> body(head.begin(), head.end());
  body.resize(body.size() + bytes);
  return body;
}

TEST(FrameHeader, isLittleEndianInTheOrderOfTheDocument) {
  const auto bytes = encodeFrameHeader({0x00010203, 0x44, 1, 0xA0B0C0D0});
  const std::array<uint8_t, kFrameHeaderBytes> expected{3, 2, 1, 0, 0x44, 1, 0, 0, 0xD0, 0xC0, 0xB0, 0xA0};
  for (size_t i = 0; i < bytes.size(); ++i) EXPECT_EQ(std::to_integer<int>(bytes[i]), expected[i]) << i;
}

TEST(FrameHeader, decodesToTheEncodedHeader) {
  const FrameHeader header{1234, 9, kFlagOptional, 77};
  EXPECT_EQ(decodeFrameHeader(encodeFrameHeader(header)), header);
}

TEST(FrameHeader, admitsTheLargestBodyAndRefusesOneByteMore) {
  EXPECT_EQ(decodeFrameHeader(encodeFrameHeader({kMaxFrameBodyBytes, 1, 0, 0})).body_bytes,
            kMaxFrameBodyBytes);
  EXPECT_EQ(errorOf([] {
              decodeFrameHeader(encodeFrameHeader({kMaxFrameBodyBytes + 1, 1, 0, 0}));
            }),
            ErrorCode::kLimit);
}

TEST(FrameHeader, refusesEveryReservedBit) {
  for (size_t byte : {5, 6, 7})
    for (int bit = 0; bit < 8; ++bit) {
      if (byte == 5 && (1 << bit) == kFlagOptional) continue;
      auto bytes = encodeFrameHeader({10, 1, 0, 0});
      bytes[byte] = static_cast<std::byte>(1 << bit);
      EXPECT_EQ(errorOf([&] { decodeFrameHeader(bytes); }), ErrorCode::kProtocol) << byte << " " << bit;
    }
}

TEST(FrameName, namesEveryTypeAndNoOther) {
  EXPECT_EQ(frameName(1), "Hello");
  EXPECT_EQ(frameName(static_cast<uint8_t>(FrameType::kClosed)), "Closed");
  EXPECT_EQ(frameName(0), "unknown");
  EXPECT_EQ(frameName(18), "unknown");
  EXPECT_EQ(frameName(255), "unknown");
}

TEST(BlobChunk, decodesToItsHeaderAndBytes) {
  auto body = blobBody({7, 100, 60}, 40);
  body.back() = std::byte{42};
  const BlobChunk chunk = decodeBlobChunk(body);
  EXPECT_EQ(chunk.header, (BlobChunkHeader{7, 100, 60}));
  ASSERT_EQ(chunk.bytes.size(), 40u);
  EXPECT_EQ(chunk.bytes.back(), std::byte{42});
}

TEST(BlobChunk, refusesABodyTooShortForItsFields) {
  for (size_t size = 0; size < kBlobChunkHeaderBytes; ++size)
    EXPECT_EQ(errorOf([&] { decodeBlobChunk(std::vector<std::byte>(size)); }), ErrorCode::kProtocol);
}

TEST(BlobChunk, refusesAChunkWithoutBytes) {
  EXPECT_EQ(errorOf([] { decodeBlobChunk(blobBody({1, 100, 50}, 0)); }), ErrorCode::kProtocol);
}

TEST(BlobChunk, refusesAChunkBeyondTheEndOfItsBlob) {
  EXPECT_NO_THROW(decodeBlobChunk(blobBody({1, 100, 90}, 10)));
  EXPECT_EQ(errorOf([] { decodeBlobChunk(blobBody({1, 100, 91}, 10)); }), ErrorCode::kProtocol);
}

TEST(BlobChunk, refusesAnOffsetThatWouldWrapAround) {
  EXPECT_EQ(errorOf([] { decodeBlobChunk(blobBody({1, 100, 0xFFFFFFFF}, 10)); }), ErrorCode::kProtocol);
}

TEST(BlobChunk, admitsTheLongestChunkAndRefusesOneByteMore) {
  EXPECT_NO_THROW(decodeBlobChunk(blobBody({1, 100'000, 0}, kMaxChunkBytes)));
  EXPECT_EQ(errorOf([] {
              decodeBlobChunk(blobBody({1, 100'000, 0}, kMaxChunkBytes + 1));
            }),
            ErrorCode::kLimit);
}

TEST(BlobChunk, admitsTheLargestBlobAndRefusesOneByteMore) {
  EXPECT_NO_THROW(decodeBlobChunk(blobBody({1, kMaxBlobBytes, 0}, 1)));
  EXPECT_EQ(errorOf([] { decodeBlobChunk(blobBody({1, kMaxBlobBytes + 1, 0}, 1)); }), ErrorCode::kLimit);
}

}  // namespace
}  // namespace lode::proto
