#include <algorithm>

#include <openssl/evp.h>

#include "common/codec/blob.h"
#include "common/error.h"

/// Computes digests with OpenSSL. The client in a browser has its own: see client/web/core.
namespace lode {

Digest digestOf(std::span<const std::byte> blob) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest;
  if (EVP_Digest(blob.data(), blob.size(), digest.data(), nullptr, EVP_sha256(), nullptr) != 1)
    throw Error(ErrorCode::kInternal, "SHA-256 failed: the OpenSSL library refuses to compute it");
  Digest name;
  std::copy_n(std::as_bytes(std::span(digest)).begin(), name.bytes.size(), name.bytes.begin());
  return name;
}

}  // namespace lode
