#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace lode::proto {

enum class FrameType : uint8_t {
  kHello = 1,
  kWelcome = 2,
  kList = 3,
  kModels = 4,
  kOpen = 5,
  kOpened = 6,
  kRequests = 7,
  kCredit = 8,
  kBlob = 9,
  kCancelled = 10,
  kError = 11,
  kGoAway = 12,
  kModelReplaced = 13,
  kPing = 14,
  kPong = 15,
  kClose = 16,
  kClosed = 17,
};

/// "Hello" and so on, for messages to people; "unknown" for a type that this version does not know.
std::string_view frameName(uint8_t type) noexcept;

constexpr uint8_t kFlagOptional = 1;  ///< who does not know the frame's type skips it

/// The fixed header of every frame: 12 bytes, little-endian: body length u32, type u8, flags u8, reserved u16
/// (zero), call id u32 (answers repeat it).
struct FrameHeader {
  uint32_t body_bytes = 0;
  uint8_t type = 0;
  uint8_t flags = 0;
  uint32_t call = 0;

  bool operator==(const FrameHeader&) const = default;
};
constexpr size_t kFrameHeaderBytes = 12;

std::array<std::byte, kFrameHeaderBytes> encodeFrameHeader(const FrameHeader& header) noexcept;

/// @throws Error kLimit if the body is longer than kMaxFrameBodyBytes, kProtocol if reserved bits are set.
FrameHeader decodeFrameHeader(std::span<const std::byte, kFrameHeaderBytes> bytes);

/// The fixed fields at the head of a Blob frame's body; raw bytes of the blob follow. Little-endian: request
/// u32, total u32 (size of the blob), offset u32 (of this chunk in it).
struct BlobChunkHeader {
  uint32_t request = 0;
  uint32_t total_bytes = 0;
  uint32_t offset_bytes = 0;

  bool operator==(const BlobChunkHeader&) const = default;
};
constexpr size_t kBlobChunkHeaderBytes = 12;

std::array<std::byte, kBlobChunkHeaderBytes> encodeBlobChunkHeader(const BlobChunkHeader& header) noexcept;

struct BlobChunk {
  BlobChunkHeader header;
  std::span<const std::byte> bytes;  ///< into the frame's body
};
/// @throws Error kProtocol if the body is too short, the chunk is empty or does not lie inside the blob;
/// kLimit for a chunk above kMaxChunkBytes or a blob above kMaxBlobBytes.
BlobChunk decodeBlobChunk(std::span<const std::byte> body);

}  // namespace lode::proto
