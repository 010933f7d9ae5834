#pragma once

#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "client/core/lod/request.h"

namespace lode::core {

constexpr size_t kMaxCacheQueries = 256;  ///< largest number of unanswered queries
/// Largest number of remembered misses. Beyond this number, all misses are forgotten and queried again.
constexpr size_t kMaxRememberedMisses = 65536;

/// Queries the blob cache before the server. Sends no second query for a blob while the first is unanswered.
/// Not thread safe.
class CacheQueries {
 public:
  /// Returns true if the cache has reported that it lacks the blob. Otherwise returns false and queries the
  /// cache; if too many queries are unanswered, a later call makes the query.
  bool isMissing(const Request& request);
  /// Returns the blobs to look up in the cache. The caller answers each with finish().
  std::vector<BlobRef> take() { return std::exchange(new_, {}); }
  /// Records the cache's answer. @return the use of the blob; nothing if the blob was not queried.
  std::optional<BlobUse> finish(const BlobRef& blob, bool found);
  /// Notes that the server has sent the blob, which the caller then adds to the cache.
  void arrived(const BlobRef& blob) { misses_.erase(blob.digest); }
  /// Returns true if a blob was missing in the cache and has not arrived since then.
  bool hasMisses() const noexcept { return !misses_.empty(); }
  bool idle() const noexcept { return asked_.empty(); }

 private:
  std::map<Digest, BlobUse> asked_;
  std::vector<BlobRef> new_;
  std::set<Digest> misses_;
};

}  // namespace lode::core
