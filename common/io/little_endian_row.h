#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

namespace lode {

/// Builds a record of a binary file, of at most 64 bytes. The record is little-endian on every machine.
class LittleEndianRow {
 public:
  template <typename T>
  void add(T value) {
    using Bits = std::conditional_t<
        sizeof(T) == 8, uint64_t,
        std::conditional_t<sizeof(T) == 4, uint32_t, std::conditional_t<sizeof(T) == 2, uint16_t, uint8_t>>>;
    const Bits bits = std::bit_cast<Bits>(value);
    for (size_t i = 0; i < sizeof(T); ++i)
      bytes_[size_++] = static_cast<std::byte>(static_cast<uint64_t>(bits) >> 8 * i & 255);
  }
  std::span<const std::byte> bytes() const { return std::span(bytes_).first(size_); }

 private:
  std::array<std::byte, 64> bytes_;
  size_t size_ = 0;
};

}  // namespace lode
