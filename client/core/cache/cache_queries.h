#pragma once

#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "client/core/lod/request.h"

namespace lode::core {

constexpr size_t kMaxCacheQueries = 256;        ///< unanswered at one time
constexpr size_t kMaxRememberedMisses = 65536;  ///< beyond it all are forgotten and queried again

/// Queries to the blob cache that precede requests to the server: each blob once, until it is answered. Not
/// thread safe.
class CacheQueries {
 public:
  /// Returns true if the cache does not have the blob. Otherwise queries the cache, now or on a later call if
  /// too many queries are open, and returns false.
  bool isMissing(const Request& request);
  /// Blobs to look up in the cache. Answer each with finish().
  std::vector<BlobRef> take() { return std::exchange(new_, {}); }
  /// @return the use of the blob; nothing if it was not queried.
  std::optional<BlobUse> finish(const BlobRef& blob, bool found);
  /// The server has sent the blob: the cache will have it.
  void arrived(const BlobRef& blob) { misses_.erase(blob.digest); }
  /// Returns true if some blob was missing in the cache and has not arrived since.
  bool hasMisses() const noexcept { return !misses_.empty(); }
  bool idle() const noexcept { return asked_.empty(); }

 private:
  std::map<Digest, BlobUse> asked_;
  std::vector<BlobRef> new_;
  std::set<Digest> misses_;
};

}  // namespace lode::core
