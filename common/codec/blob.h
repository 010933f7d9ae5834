#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace lode {

/// The first 128 bits of a blob's SHA-256. Caches use the digest as the blob's key.
struct Digest {
  std::array<std::byte, 16> bytes{};
  friend constexpr auto operator<=>(const Digest&, const Digest&) = default;
};

Digest digestOf(std::span<const std::byte> blob);
std::string toHex(const Digest& digest);  ///< returns 32 lower-case digits

/// Reference to a blob, for requests and checks: the blob's number in the store, size and digest.
struct BlobRef {
  uint32_t number = 0;  ///< number in the store; 0 means no blob, as for an LOD without triangles
  uint32_t bytes = 0;
  Digest digest;

  bool operator==(const BlobRef&) const = default;
  explicit operator bool() const noexcept { return number != 0; }
};

/// Returns the 64-bit xxh3 checksum, which detects damage. Use a Digest to identify a blob.
uint64_t checksum(std::span<const std::byte> bytes) noexcept;

}  // namespace lode
