#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace lode::proto {

/// Lists every message as X(number, name, struct in messages.h). The name is that of the table in
/// lodestream.fbs and, after a k, of the FrameType. The numbers are part of the protocol: never change or
/// reuse a number.
#define LODE_MESSAGES(X)              \
  X(1, Hello, Hello)                  \
  X(2, Welcome, Welcome)              \
  X(3, List, List)                    \
  X(4, Models, Models)                \
  X(5, Open, Open)                    \
  X(6, Opened, Opened)                \
  X(7, Requests, Requests)            \
  X(8, Credit, Credit)                \
  X(10, Cancelled, Cancelled)         \
  X(11, Error, ErrorMessage)          \
  X(12, GoAway, GoAway)               \
  X(13, ModelReplaced, ModelReplaced) \
  X(14, Ping, Ping)                   \
  X(15, Pong, Pong)                   \
  X(16, Close, Close)                 \
  X(17, Closed, Closed)

enum class FrameType : uint8_t {
#define LODE_MESSAGE(number, name, type) k##name = (number),
  LODE_MESSAGES(LODE_MESSAGE)
#undef LODE_MESSAGE
      kBlob = 9,  ///< frame without a message: the body is a BlobChunkHeader, then raw bytes
};

/// Returns the name of a frame type for error messages: "Hello" and so on, or "unknown".
std::string_view frameName(uint8_t type) noexcept;
/// Returns true if this version of the protocol has the frame type.
bool isFrameType(uint8_t type) noexcept;

constexpr uint8_t kFlagOptional = 1;  ///< flag of frames that a receiver skips if it does not know the type

/// Header of every frame, 12 bytes, little-endian: body length u32, type u8, flags u8, reserved u16 (zero),
/// call id u32. An answer has the call id of the frame that it answers.
struct FrameHeader {
  uint32_t body_bytes = 0;
  uint8_t type = 0;
  uint8_t flags = 0;
  uint32_t call = 0;

  bool operator==(const FrameHeader&) const = default;
};
constexpr size_t kFrameHeaderBytes = 12;

std::array<std::byte, kFrameHeaderBytes> encodeFrameHeader(const FrameHeader& header) noexcept;

/// @throws Error kLimit if the header announces more than kMaxFrameBodyBytes, kProtocol if reserved bits are
/// set.
FrameHeader decodeFrameHeader(std::span<const std::byte, kFrameHeaderBytes> bytes);

/// Head of a Blob frame's body, 12 bytes, little-endian: request u32, size of the blob u32, offset of this
/// chunk in the blob u32. The chunk's raw bytes follow.
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
  std::span<const std::byte> bytes;  ///< points into the frame's body
};
/// @throws Error kProtocol if the body is too short, or the chunk is empty or exceeds its blob; kLimit if the
/// chunk exceeds kMaxChunkBytes or the blob kMaxBlobBytes.
BlobChunk decodeBlobChunk(std::span<const std::byte> body);

}  // namespace lode::proto
