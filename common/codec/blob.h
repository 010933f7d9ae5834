#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace lode {

/// Name of a blob: SHA-256 of its bytes, cut to 128 bits. Caches go by it.
struct Digest {
  std::array<std::byte, 16> bytes{};
  friend constexpr auto operator<=>(const Digest&, const Digest&) = default;
};

Digest digestOf(std::span<const std::byte> blob);
std::string toHex(const Digest& name);  ///< 32 lower-case digits

/// How a blob is asked for and checked: its number in the store, its size and its name.
struct BlobRef {
  uint32_t number = 0;  ///< 0 is no blob: an LOD without triangles
  uint32_t bytes = 0;
  Digest digest;

  bool operator==(const BlobRef&) const = default;
  explicit operator bool() const noexcept { return number != 0; }
};

/// xxh3, 64 bits: damage detection only, never a name.
uint64_t checksum(std::span<const std::byte> bytes) noexcept;

}  // namespace lode
