#include "client/app/cli/known_names.h"

namespace lode::app {

bool KnownNames::isNamed(const BlobRef& blob, std::span<const std::byte> bytes) {
  const auto known = checksums_.find(blob.name);
  if (known != checksums_.end()) return checksum(bytes) == known->second;
  if (nameBlob(bytes) != blob.name) return false;
  checksums_.emplace(blob.name, checksum(bytes));
  return true;
}

}  // namespace lode::app
