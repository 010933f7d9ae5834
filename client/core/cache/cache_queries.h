#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "client/core/lod/request.h"

namespace lode::core {

constexpr size_t kMaxCacheQueries = 256;  ///< largest number of unanswered queries
/// Largest number of remembered misses. When it is reached, CacheQueries forgets them all.
constexpr size_t kMaxRememberedMisses = 65536;

/// Asks the blob cache for each blob before the server is asked. Never has two open queries for the same
/// blob. Not thread safe.
class CacheQueries {
 public:
  /// Returns true if the cache has reported that it lacks the blob. Otherwise returns false and queues a
  /// query, unless a query for the blob is open. If there is no room for another query, call again after the
  /// next finish().
  /// @param most_bytes  limit for the total size of the blobs of unanswered queries, because the cache may
  ///                    have them all; a single blob may be larger.
  bool isMissing(const Request& request, uint64_t most_bytes);
  /// Returns the blobs to look up in the cache, and clears the queue. The caller answers each with finish().
  std::vector<BlobRef> take() { return std::exchange(new_, {}); }
  /// Records the cache's answer. @return the use that was passed to isMissing(); nothing if no query for the
  /// blob is open.
  std::optional<BlobUse> finish(const BlobRef& blob, bool found);
  /// Notes that the server has sent the blob, so that it is no longer a miss. The caller also caches the
  /// blob.
  void arrived(const BlobRef& blob) { misses_.erase(blob.digest); }
  /// Returns true while some blob that the cache lacks has not arrived from the server.
  bool hasMisses() const noexcept { return !misses_.empty(); }
  bool idle() const noexcept { return asked_.empty(); }

 private:
  struct Query {
    BlobUse use;
    uint32_t bytes = 0;  // size of the blob
  };
  std::map<Digest, Query> asked_;
  uint64_t asked_bytes_ = 0;  // total size of the blobs in asked_
  std::vector<BlobRef> new_;
  std::set<Digest> misses_;
};

}  // namespace lode::core
