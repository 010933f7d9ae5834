#pragma once

#include <cstdint>
#include <map>
#include <span>

#include "common/codec/blob.h"

namespace lode::app {

/// Checks names of blobs that come over and over: SHA-256 of the first of each, of the others xxh3, which
/// must be that of the first. Not thread safe.
class KnownDigests {
 public:
  bool matchesDigest(const BlobRef& blob, std::span<const std::byte> bytes);

 private:
  std::map<Digest, uint64_t> checksums_;  ///< of bytes that have the name
};

}  // namespace lode::app
