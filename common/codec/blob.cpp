#include "common/codec/blob.h"

#include <algorithm>

#include <openssl/evp.h>
#include <xxhash.h>

#include "common/error.h"

namespace lode {

Digest digestOf(std::span<const std::byte> blob) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest;
  if (EVP_Digest(blob.data(), blob.size(), digest.data(), nullptr, EVP_sha256(), nullptr) != 1)
    throw Error(ErrorCode::kInternal, "SHA-256 failed: the OpenSSL library refuses to compute it");
  Digest name;
  std::copy_n(std::as_bytes(std::span(digest)).begin(), name.bytes.size(), name.bytes.begin());
  return name;
}

std::string toHex(const Digest& name) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string hex;
  hex.reserve(2 * name.bytes.size());
  for (const std::byte byte : name.bytes) {
    hex += kDigits[std::to_integer<unsigned>(byte >> 4)];
    hex += kDigits[std::to_integer<unsigned>(byte & std::byte{15})];
  }
  return hex;
}

uint64_t checksum(std::span<const std::byte> bytes) noexcept {
  return XXH3_64bits(bytes.data(), bytes.size());
}

}  // namespace lode
