#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "common/error.h"

/// Settings and parsing that the encoder and the decoder of payloads share.
namespace lode::draco_stream {

constexpr int kNormalBits = 8;
constexpr int kTextureBits = 16;

[[noreturn]] inline void refuse(const std::string& why) {
  throw Error(ErrorCode::kFormat, "damaged payload: " + why + "; fetch it again or rebuild the store");
}

/// Reads the header of a Draco stream, or the bytes that follow the stream. All functions throw Error
/// kFormat.
/// Source: Draco's bitstream specification 2.2, sections 3 and 6.
class Cursor {
 public:
  explicit Cursor(std::span<const std::byte> bytes) : bytes_(bytes) {}

  /// Skips the first bytes, which are the same in every payload. The next bytes are the kind of traversal and
  /// the numbers of vertices and triangles.
  void skipStart() {
    constexpr uint8_t kStart[] = {'D',         'R', 'A', 'C', 'O', 2, 2, /*mesh*/ 1, /*edgebreaker*/ 1,
                                  /*flags*/ 0, 0};
    for (const uint8_t byte : kStart)
      if (u8() != byte) refuse("it does not begin as a Draco 2.2 edgebreaker mesh");
  }
  bool isAtEnd() const noexcept { return at_ == bytes_.size(); }
  uint8_t u8() {
    if (isAtEnd()) refuse("it is cut off");
    return std::to_integer<uint8_t>(bytes_[at_++]);
  }
  uint32_t varint() {
    uint64_t value = 0;
    for (int shift = 0; shift < 35; shift += 7) {
      const uint8_t byte = u8();
      value |= static_cast<uint64_t>(byte & 127) << shift;
      if (byte < 128 && value <= UINT32_MAX) return static_cast<uint32_t>(value);
    }
    refuse("a number in it is too long");
  }

 private:
  std::span<const std::byte> bytes_;
  size_t at_ = 0;
};

}  // namespace lode::draco_stream
