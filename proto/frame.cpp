#include "proto/frame.h"

#include <string>

#include "common/error.h"
#include "common/limits.h"
#include "proto/limits.h"

namespace lode::proto {

namespace {

void putU32(std::byte* at, uint32_t value) noexcept {
  for (int i = 0; i < 4; ++i) at[i] = static_cast<std::byte>(value >> 8 * i);
}

uint32_t getU32(const std::byte* at) noexcept {
  uint32_t value = 0;
  for (int i = 0; i < 4; ++i) value |= std::to_integer<uint32_t>(at[i]) << 8 * i;
  return value;
}

}  // namespace

std::string_view frameName(uint8_t type) noexcept {
  switch (static_cast<FrameType>(type)) {
    case FrameType::kBlob:
      return "Blob";
#define LODE_MESSAGE(number, name, type) \
  case FrameType::k##name:               \
    return #name;
      LODE_MESSAGES(LODE_MESSAGE)
#undef LODE_MESSAGE
  }
  return "unknown";
}

bool isFrameType(uint8_t type) noexcept { return frameName(type) != "unknown"; }

std::array<std::byte, kFrameHeaderBytes> encodeFrameHeader(const FrameHeader& header) noexcept {
  std::array<std::byte, kFrameHeaderBytes> bytes{};
  putU32(bytes.data(), header.body_bytes);
  bytes[4] = std::byte{header.type};
  bytes[5] = std::byte{header.flags};
  putU32(bytes.data() + 8, header.call);
  return bytes;
}

FrameHeader decodeFrameHeader(std::span<const std::byte, kFrameHeaderBytes> bytes) {
  FrameHeader header;
  header.body_bytes = getU32(bytes.data());
  header.type = std::to_integer<uint8_t>(bytes[4]);
  header.flags = std::to_integer<uint8_t>(bytes[5]);
  header.call = getU32(bytes.data() + 8);
  if (header.body_bytes > kMaxFrameBodyBytes)
    throw Error(ErrorCode::kLimit, "a frame announces a body of " + std::to_string(header.body_bytes) +
                                       " bytes; the limit is " + std::to_string(kMaxFrameBodyBytes));
  if ((header.flags & ~kFlagOptional) != 0 || bytes[6] != std::byte{0} || bytes[7] != std::byte{0})
    throw Error(ErrorCode::kProtocol, "a frame header has reserved bits set; is this a Lodestream peer?");
  return header;
}

std::array<std::byte, kBlobChunkHeaderBytes> encodeBlobChunkHeader(const BlobChunkHeader& header) noexcept {
  std::array<std::byte, kBlobChunkHeaderBytes> bytes{};
  putU32(bytes.data(), header.request);
  putU32(bytes.data() + 4, header.total_bytes);
  putU32(bytes.data() + 8, header.offset_bytes);
  return bytes;
}

BlobChunk decodeBlobChunk(std::span<const std::byte> body) {
  if (body.size() <= kBlobChunkHeaderBytes)
    throw Error(ErrorCode::kProtocol,
                "a Blob frame of " + std::to_string(body.size()) + " bytes carries no bytes of a blob");
  BlobChunk chunk;
  chunk.header.request = getU32(body.data());
  chunk.header.total_bytes = getU32(body.data() + 4);
  chunk.header.offset_bytes = getU32(body.data() + 8);
  chunk.bytes = body.subspan(kBlobChunkHeaderBytes);
  if (chunk.bytes.size() > kMaxChunkBytes)
    throw Error(ErrorCode::kLimit, "a Blob frame carries " + std::to_string(chunk.bytes.size()) +
                                       " bytes; the limit is " + std::to_string(kMaxChunkBytes));
  if (chunk.header.total_bytes > kMaxBlobBytes)
    throw Error(ErrorCode::kLimit, "a Blob frame announces a blob of " +
                                       std::to_string(chunk.header.total_bytes) + " bytes; the limit is " +
                                       std::to_string(kMaxBlobBytes));
  if (uint64_t{chunk.header.offset_bytes} + chunk.bytes.size() > chunk.header.total_bytes)
    throw Error(ErrorCode::kProtocol, "a chunk at byte " + std::to_string(chunk.header.offset_bytes) +
                                          " goes beyond its blob of " +
                                          std::to_string(chunk.header.total_bytes) + " bytes");
  return chunk;
}

}  // namespace lode::proto
