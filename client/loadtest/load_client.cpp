#include "client/loadtest/load_client.h"

namespace lode::app {

bool KnownDigests::matchesDigest(const BlobRef& blob, std::span<const std::byte> bytes) {
  const auto known = checksums_.find(blob.digest);
  if (known != checksums_.end()) return checksum(bytes) == known->second;
  if (digestOf(bytes) != blob.digest) return false;
  if (checksums_.size() >= kMaxKnownDigests) checksums_.clear();
  checksums_.emplace(blob.digest, checksum(bytes));
  return true;
}

}  // namespace lode::app
